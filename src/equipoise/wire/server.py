"""The robot's end of the UDP wire: takes commands of one commander and sends it states."""

from __future__ import annotations

from dataclasses import dataclass

from equipoise.wire.datagrams import Address, Datagrams
from equipoise.wire.end import End, out_of_order
from equipoise.wire.interface import CommandMode, RobotCommand, RobotState
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Fault, Header, Kind, Parties, Refusal

FORGOTTEN = 1.0  # [s] of silence after which one who only listens loses its place


@dataclass
class Partner:
    """Who is spoken with: its session, where it is, its newest packet and when that came [s]."""

    session: int
    address: Address
    sequence: int
    heard: float
    commands: bool = False


class UdpServer(End):
    """Speaks with one partner, who first listens and may then command.

    Who has commanded once is the commander to the end: its session and its address are pinned.
    Anybody else is counted as FOREIGN and told so. A command that answers a state older than
    `oldest` [s], or one that was never sent, is dropped.
    """

    def __init__(self, model: WireModel, datagrams: Datagrams, oldest: float) -> None:
        super().__init__(model, datagrams)
        self.oldest = oldest
        self.partner: Partner | None = None

    @property
    def has_commander(self) -> bool:
        """Whether anybody has commanded."""
        return self.partner is not None and self.partner.commands

    def now(self) -> float:
        """Return the time [s] on a clock that only goes forward."""
        return self.datagrams.now()

    def wait(self, until: float) -> None:
        """Return once something has arrived, or at the time `until` [s]."""
        self.datagrams.wait(until)

    def receive(self, t: float) -> RobotCommand | None:
        """Return the newest good command that has arrived by the robot's time `t` [s].

        One that says HOLD is not overtaken by a later torque.
        """
        newest: RobotCommand | None = None
        for packet, header, sender in self.packets():
            if isinstance(header, Fault):
                self.drop(header)
                if header is Fault.MODEL:
                    self._refuse(sender, 0, Refusal.OTHER_MODEL)
                continue
            taken = self._taken(packet, header, sender, t)
            if isinstance(taken, Fault):
                self.drop(taken)
            elif taken is not None and (newest is None or newest.mode is not CommandMode.HOLD):
                newest = taken
        return newest

    def _taken(
        self, packet: bytes, header: Header, sender: Address, t: float
    ) -> RobotCommand | Fault | None:
        """Return a command, None for a hello, or why the packet is dropped."""
        if header.kind not in (Kind.HELLO, Kind.COMMAND):
            return Fault.KIND
        commands = header.kind is Kind.COMMAND
        if header.receiver != self.session and (commands or header.receiver != 0):
            return Fault.FOREIGN  # meant for another robot, or recorded in another run
        partner = self._place_for(header, sender)
        if partner is None:
            self._refuse(sender, header.sender, Refusal.TAKEN)
            return Fault.FOREIGN
        wrong = out_of_order(header.sequence, partner.sequence)
        if wrong is not None:
            return wrong
        command = self.codec.command_in(packet, header) if commands else None
        if isinstance(command, Fault):
            return command
        if command is not None and not self._answers_in_time(command, t):
            return Fault.OLD
        partner.sequence, partner.heard = header.sequence, self.datagrams.now()
        partner.commands = partner.commands or commands
        self.partner = partner
        return command

    def _answers_in_time(self, command: RobotCommand, t: float) -> bool:
        """Tell whether a command answers a state that was sent and is young; stopping always is."""
        return command.mode is CommandMode.HOLD or 0.0 <= t - command.t <= self.oldest

    def _place_for(self, header: Header, sender: Address) -> Partner | None:
        """Return the partner that sent this; a new one where the place is free, None if not."""
        one = self.partner
        if one is not None and (one.session, one.address) == (header.sender, sender):
            return one
        if one is not None and one.commands:
            return None
        if one is not None and self.datagrams.now() - one.heard < FORGOTTEN:
            return None
        return Partner(header.sender, sender, 0, self.datagrams.now())

    def _refuse(self, sender: Address, session: int, why: Refusal) -> None:
        whose = Parties(self.session, session)
        self.datagrams.send(self.codec.refusal(whose, why), sender)

    def send(self, state: RobotState) -> RobotState:
        """Send a state to the partner, if there is one; return it with its sequence number."""
        numbered = state._replace(sequence=self.next_sequence())
        if self.partner is not None:
            whose = Parties(self.session, self.partner.session)
            self.datagrams.send(self.codec.state(whose, numbered), self.partner.address)
        return numbered

    def close(self) -> None:
        """Close the socket."""
        self.datagrams.close()
