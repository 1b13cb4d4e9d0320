"""Two ends of the UDP wire: the robot's, which serves, and the loop's, which asks.

What arrives is believed only if it is whole, of the same model, of the one that is spoken with, and
newer than the last; the rest is counted and dropped. This keeps faults out, not an attacker.
"""

from __future__ import annotations

import os
import socket
from collections import Counter
from collections.abc import Iterator
from select import select
from time import monotonic

from equipoise.errors import InputError
from equipoise.wire.interface import RobotCommand, RobotState
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Codec, Fault, Header, Kind

PORT = 47100
LOCAL = "127.0.0.1"
AT_ONCE = 256  # packets looked at in one go: a flood does not hold up a loop
HELLO_EVERY = 0.1  # [s] while nothing is commanded
Address = tuple[str, int]


class _End:
    """A socket that believes nothing: shared by both ends."""

    def __init__(self, model: WireModel) -> None:
        self.codec = Codec(model)
        self.session = int.from_bytes(os.urandom(8), "little") or 1
        self.dropped: Counter[Fault] = Counter()
        self.other_model: bytes | None = None  # digest of one who speaks of another robot
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._sequence = 0

    @property
    def address(self) -> Address:
        """Where this end listens."""
        host, port = self._socket.getsockname()
        return host, port

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def _next(self) -> int:
        self._sequence += 1
        return self._sequence

    def _wait(self, timeout: float) -> None:
        """Wait until something has arrived, or `timeout` [s] is over."""
        select([self._socket], [], [], max(timeout, 0.0))

    def _packets(self) -> Iterator[tuple[bytes, Header, Address]]:
        """Yield what has arrived, whole and of this model; count the rest."""
        for _ in range(AT_ONCE):
            try:
                packet, sender = self._socket.recvfrom(self.codec.longest + 1)
            except BlockingIOError:
                return
            except OSError:  # nobody at the other end (ICMP): as if nothing had come
                continue
            header = self.codec.header(packet)
            if isinstance(header, Fault):
                self.dropped[header] += 1
                if header is Fault.MODEL:
                    self._other(packet, sender)
                continue
            yield packet, header, sender

    def _other(self, packet: bytes, sender: Address) -> None:
        self.other_model = packet[40:56]

    def _send(self, packet: bytes, to: Address) -> None:
        try:
            self._socket.sendto(packet, to)
        except OSError:
            return  # a lost packet: the network is full or away


class UdpServer(_End):
    """The robot's end: takes commands of one commander, sends states to who listens.

    Who commands first is the commander to the end; a second one is counted as FOREIGN. Raises: `InputError` if the address is taken or does not exist.
    """

    def __init__(self, model: WireModel, address: Address = (LOCAL, PORT)) -> None:
        super().__init__(model)
        try:
            self._socket.bind(address)
        except OSError as error:
            self.close()
            raise InputError(
                f"cannot listen at {address[0]} port {address[1]}: {error.strerror}",
                remedy="Name another --port; 0 takes a free one",
            ) from None
        self.commander: int | None = None
        self._last = 0  # sequence of the commander's newest packet
        self._listener: tuple[int, Address] | None = None

    def receive(self, timeout: float) -> RobotCommand | None:
        """Return the newest good command, waiting `timeout` [s] at most for anything to arrive."""
        self._wait(timeout)
        newest: RobotCommand | None = None
        for packet, header, sender in self._packets():
            if header.kind is Kind.HELLO:
                if self.commander is None:
                    self._listener = header.sender, sender
                continue
            taken = self._taken(packet, header)
            if isinstance(taken, Fault):
                self.dropped[taken] += 1
                continue
            self.commander, self._last = header.sender, header.sequence
            self._listener = header.sender, sender
            newest = taken
        return newest

    def _taken(self, packet: bytes, header: Header) -> RobotCommand | Fault:
        if header.kind is not Kind.COMMAND:
            return Fault.KIND
        if header.receiver != self.session:
            return Fault.FOREIGN  # meant for another robot, or recorded in another run
        if self.commander is not None and header.sender != self.commander:
            return Fault.FOREIGN
        if self.commander is not None and header.sequence <= self._last:
            return Fault.OLD
        return self.codec.command_in(packet, header)

    def _other(self, packet: bytes, sender: Address) -> None:
        """Tell who speaks of another robot which one this is; once for each of its packets."""
        super()._other(packet, sender)
        self._send(self.codec.hello(self.session, 0, self._next()), sender)

    def send(self, state: RobotState) -> RobotState:
        """Send a state to who listens, if anybody does; return it with its sequence number."""
        numbered = state._replace(sequence=self._next())
        if self._listener is not None:
            session, address = self._listener
            self._send(self.codec.state(self.session, session, numbered), address)
        return numbered


class UdpRobot(_End):
    """The loop's end: a `RobotInterface` of a robot behind an address.

    `missing` counts states that were sent and never came (a late one that was overtaken is one).
    """

    def __init__(self, model: WireModel, address: Address = (LOCAL, PORT)) -> None:
        super().__init__(model)
        try:
            self._robot: Address = (socket.gethostbyname(address[0]), address[1])
            self._socket.bind((LOCAL if self._robot[0].startswith("127.") else "", 0))
        except OSError as error:
            self.close()
            raise InputError(f"there is no address {address[0]}: {error.strerror}") from None
        self.robot_session: int | None = None
        self.missing = 0
        self._last = 0
        self._hello_at = -float("inf")
        self._commands = False

    def read(self, timeout: float) -> RobotState | None:
        """Return the newest state not read before; see `RobotInterface`."""
        until = monotonic() + timeout
        while True:
            self._say_hello()
            left = until - monotonic()
            self._wait(min(left, HELLO_EVERY))
            state = self._newest()
            if state is not None or left <= 0.0 or self.other_model is not None:
                return state

    def _say_hello(self) -> None:
        """Say who listens, as long as no command says it."""
        if not self._commands and monotonic() - self._hello_at >= HELLO_EVERY:
            self._hello_at = monotonic()
            to = self.robot_session or 0
            self._send(self.codec.hello(self.session, to, self._next()), self._robot)

    def _newest(self) -> RobotState | None:
        newest: RobotState | None = None
        for packet, header, sender in self._packets():
            state = self._taken(packet, header, sender)
            if isinstance(state, Fault):
                self.dropped[state] += 1
                continue
            if self.robot_session is not None:
                self.missing += state.sequence - self._last - 1
            self.robot_session, self._last = header.sender, state.sequence
            newest = state
        return newest

    def _taken(self, packet: bytes, header: Header, sender: Address) -> RobotState | Fault:
        if sender != self._robot or header.receiver != self.session:
            return Fault.FOREIGN
        if header.kind is not Kind.STATE:
            return Fault.KIND
        if self.robot_session is not None and header.sender != self.robot_session:
            return Fault.FOREIGN  # a robot that was started anew: its time is another one
        if header.sequence <= self._last:
            return Fault.OLD
        return self.codec.state_in(packet, header)

    def write(self, command: RobotCommand) -> None:
        """Send a command to the robot that was heard; see `RobotInterface`.

        Raises: `InputError`, also before a first state was read.
        """
        if self.robot_session is None:
            raise InputError("no robot has been heard yet", remedy="Read a state first")
        packet = self.codec.command(self.session, self.robot_session, self._next(), command)
        self._commands = True
        self._send(packet, self._robot)
