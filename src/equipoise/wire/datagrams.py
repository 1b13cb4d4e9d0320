"""Packets out and in: a UDP socket that never blocks and never raises on what the network does."""

from __future__ import annotations

import socket
from select import select
from time import monotonic
from typing import Protocol

from equipoise.errors import InputError

Address = tuple[str, int]
LOCAL, PORT = "127.0.0.1", 47100


class Datagrams(Protocol):
    """A place where packets come and go, and its clock."""

    @property
    def address(self) -> Address:
        """Where it listens."""

    def now(self) -> float:
        """Return the time [s] on a clock that only goes forward."""

    def wait(self, until: float) -> None:
        """Return once something has arrived, or at the time `until` [s]."""

    def take(self) -> tuple[bytes, Address] | None:
        """Return the next packet and where it comes from, None if there is none."""

    def send(self, packet: bytes, to: Address) -> None:
        """Send a packet; it may be lost."""

    def close(self) -> None:
        """Take nothing any more."""


class UdpSocket:
    """A UDP socket at an address; port 0 takes a free one.

    Raises: `InputError` if the address is taken or does not exist.
    """

    def __init__(self, address: Address, longest: int) -> None:
        self._longest = longest
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind(address)
        except OSError as error:
            self._socket.close()
            raise InputError(
                f"cannot listen at {address[0]} port {address[1]}: {error.strerror}",
                remedy="Name another --wire-port or --wire-host; port 0 takes a free one",
            ) from None
        self._address: Address = self._socket.getsockname()

    @property
    def address(self) -> Address:
        """Where it listens."""
        return self._address

    def now(self) -> float:
        """Return the time [s] of the machine's monotonic clock."""
        return monotonic()

    def wait(self, until: float) -> None:
        """Return once something has arrived, or at the time `until` [s]."""
        select([self._socket], [], [], max(until - monotonic(), 0.0))

    def take(self) -> tuple[bytes, Address] | None:
        """Return the next packet and where it comes from, None if there is none.

        A packet that is longer than any of this protocol comes cut, and is then of a wrong size.
        """
        try:
            packet, sender = self._socket.recvfrom(self._longest + 1)
        except OSError:  # nothing there, or an earlier packet found nobody (ICMP)
            return None
        return packet, sender

    def send(self, packet: bytes, to: Address) -> None:
        """Send a packet; it is lost if the network is full or away."""
        try:
            self._socket.sendto(packet, to)
        except OSError:
            return

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def resolved(host: str) -> str:
    """Return the IPv4 address of a host. Raises: `InputError`."""
    try:
        return socket.gethostbyname(host)
    except OSError as error:
        raise InputError(f"there is no host {host!r}: {error.strerror}") from None


def own_side(robot: str) -> str:
    """Return the own address from which a robot's IPv4 address is reached: loopback for its own.

    Raises: `InputError` if there is no way to it.
    """
    probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        probe.connect((robot, PORT))  # sends nothing: it only chooses the way
        return str(probe.getsockname()[0])
    except OSError as error:
        raise InputError(f"there is no way to {robot}: {error.strerror}") from None
    finally:
        probe.close()
