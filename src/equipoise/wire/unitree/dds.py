"""Messages as bytes over DDS: a participant that writes one topic and takes another.

Needs the extra `wire` (cyclonedds), which is asked for only here.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import monotonic
from typing import Any

from equipoise.errors import InputError

DEPTH = 16  # messages kept until they are taken
LOOPBACK = "lo"

CONFIGURATION = """<CycloneDDS><Domain id="any"><General><Interfaces>
<NetworkInterface name="{interface}" multicast="{multicast}"/>
</Interfaces>{alone}</General>{peers}</Domain></CycloneDDS>"""


@dataclass(frozen=True)
class DdsOptions:
    """Where to meet: domain number and network interface, this machine alone by default."""

    domain: int = 0
    interface: str = LOOPBACK

    def configuration(self) -> str:
        """Return the configuration for Cyclone DDS."""
        if self.interface != LOOPBACK:
            return CONFIGURATION.format(
                interface=self.interface, multicast="default", alone="", peers=""
            )
        return CONFIGURATION.format(
            interface=LOOPBACK,
            multicast="false",
            alone="<AllowMulticast>false</AllowMulticast>",
            peers=(
                "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
                '<Peers><Peer address="127.0.0.1"/></Peers></Discovery>'
            ),
        )


_domains: dict[DdsOptions, Any] = {}


class DdsEnd:
    """Takes messages of one topic and writes another, both as bytes.

    Raises: `InputError` if Cyclone DDS is not installed or cannot use the interface.
    """

    def __init__(self, takes: str, writes: str, options: DdsOptions) -> None:
        types = _types()
        try:
            from cyclonedds.core import (
                DDSException,
                InstanceState,
                Policy,
                Qos,
                ReadCondition,
                SampleState,
                ViewState,
                WaitSet,
            )
            from cyclonedds.domain import Domain, DomainParticipant
            from cyclonedds.pub import DataWriter
            from cyclonedds.sub import DataReader
            from cyclonedds.topic import Topic
        except ImportError as error:  # a broken installation: the types were there
            raise _missing() from error
        try:
            if options not in _domains:  # a process has one of each number
                _domains[options] = Domain(options.domain, options.configuration())
            self._participant = DomainParticipant(options.domain)
        except DDSException as error:
            raise InputError(
                f"DDS cannot use the interface {options.interface!r} in domain {options.domain}",
                given=str(error),
            ) from None
        kept = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(DEPTH))
        self._reader = DataReader(self._participant, Topic(self._participant, *types[takes]), kept)
        unread = SampleState.NotRead | ViewState.Any | InstanceState.Any
        self._waiting = WaitSet(self._participant)
        self._waiting.attach(ReadCondition(self._reader, unread))
        sent = Qos(Policy.Reliability.Reliable(0), Policy.History.KeepLast(1))
        self._writer = DataWriter(self._participant, Topic(self._participant, *types[writes]), sent)
        self._write_type = types[writes][1]

    def now(self) -> float:
        """Return the time [s] of the machine's monotonic clock."""
        return monotonic()

    def wait(self, until: float) -> None:
        """Return once a message has arrived, or at the time `until` [s]."""
        left = until - monotonic()
        if left > 0.0:
            self._waiting.wait(int(1e9 * left))

    def take(self) -> tuple[bytes, int] | None:
        """Return the next message and a number for who wrote it, None if there is none."""
        samples = self._reader.take(1)
        if not samples:
            return None
        packet = getattr(samples[0], "packet", None)
        if packet is None:
            return self.take()  # news of a writer that has left, no message
        return packet, samples[0].sample_info.publication_handle

    def send(self, packet: bytes) -> None:
        """Write a message."""
        self._writer.write(self._write_type.of(packet))

    def close(self) -> None:
        """Leave the domain."""
        self._waiting = self._reader = self._writer = self._participant = None


def _missing() -> InputError:
    return InputError(
        "the unitree wire needs Cyclone DDS, which is not installed",
        remedy="pip install 'equipoise[wire]' (Python 3.11 to 3.13)",
    )


def _types() -> dict[str, tuple[str, Any]]:
    """Return by topic its name and type. Raises: `InputError` without Cyclone DDS."""
    try:
        from equipoise.wire.unitree.idl import LowCmd_, LowState_
    except ImportError as error:
        raise _missing() from error
    return {"rt/lowcmd": ("rt/lowcmd", LowCmd_), "rt/lowstate": ("rt/lowstate", LowState_)}
