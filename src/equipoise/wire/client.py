"""The loop's end of the UDP wire: a robot behind an address, read and written."""

from __future__ import annotations

import numpy as np

from equipoise.errors import InputError
from equipoise.wire.datagrams import Address, Datagrams
from equipoise.wire.end import End, out_of_order
from equipoise.wire.interface import CommandMode, RobotCommand, RobotLostError, RobotState
from equipoise.wire.model import WireModel
from equipoise.wire.packets import REFUSALS, Fault, Header, Kind, Parties, Refusal

HELLO_EVERY = 0.1  # [s] while nothing is commanded
FAREWELLS = 3  # copies of the last word, any of which may be lost
REASONS = {
    Refusal.OTHER_MODEL: "the robot there, its contacts, limits, period or pace are other ones",
    Refusal.TAKEN: "somebody else is already connected to the robot",
}


class UdpRobot(End):
    """A `RobotInterface` of a robot behind an address.

    `missing` counts states that were sent and never came, or came too late to be read. The first
    robot that answers is spoken with to the end; one that is started anew is another one.
    """

    def __init__(self, model: WireModel, datagrams: Datagrams, robot: Address) -> None:
        super().__init__(model, datagrams)
        self.missing = 0
        self.robot_session: int | None = None
        self._robot = robot
        self._last, self._last_t = 0, 0.0
        self._hello_due = -np.inf
        self._commands = self._closed = False
        self._refused: Refusal | None = None

    def read(self, timeout: float) -> RobotState | None:
        """Return the newest state not read before; see `RobotInterface`."""
        until = self.datagrams.now() + timeout
        while True:
            self._say_hello()
            self.datagrams.wait(until if self._commands else min(until, self._hello_due))
            state = self._newest()
            if self._refused is not None:
                raise RobotLostError(f"The robot does not listen: {REASONS[self._refused]}.")
            if state is not None or self.datagrams.now() >= until:
                return state

    def _say_hello(self) -> None:
        """Say who listens, as long as no command says it."""
        now = self.datagrams.now()
        if not self._commands and now >= self._hello_due:
            self._hello_due = now + HELLO_EVERY
            whose = Parties(self.session, self.robot_session or 0)
            self.datagrams.send(self.codec.hello(whose, self.next_sequence()), self._robot)

    def _newest(self) -> RobotState | None:
        newest: RobotState | None = None
        for packet, header, sender in self.packets():
            if isinstance(header, Fault):
                self.drop(header)
                continue
            state = self._taken(packet, header, sender)
            if isinstance(state, Fault):
                self.drop(state)
            elif state is not None:
                if self.robot_session is not None:
                    self.missing += state.sequence - self._last - 1
                self.robot_session = header.sender
                self._last, self._last_t, newest = state.sequence, state.t, state
        return newest

    def _taken(self, packet: bytes, header: Header, sender: Address) -> RobotState | Fault | None:
        """Return a state, None for a refusal, or why the packet is dropped."""
        if sender != self._robot or header.receiver not in (self.session, 0):
            return Fault.FOREIGN
        if header.kind is Kind.REFUSAL:
            if self.robot_session is None and header.mode in REFUSALS:
                self._refused = Refusal(header.mode)
                return None
            return Fault.FOREIGN  # one who is listened to is not refused
        if header.kind is not Kind.STATE:
            return Fault.KIND
        if header.receiver != self.session:
            return Fault.FOREIGN
        if self.robot_session is not None:
            if header.sender != self.robot_session:
                return Fault.FOREIGN  # a robot that was started anew: its time is another one
            wrong = out_of_order(header.sequence, self._last)
            if wrong is not None:
                return wrong
        if header.t < self._last_t:
            return Fault.OLD
        return self.codec.state_in(packet, header)

    def write(self, command: RobotCommand) -> None:
        """Send a command to the robot that was heard; see `RobotInterface`.

        Raises: `InputError`, also before a first state was read.
        """
        if self.robot_session is None:
            raise InputError("no robot has been heard yet", remedy="Read a state first")
        whose = Parties(self.session, self.robot_session)
        packet = self.codec.command(whose, self.next_sequence(), command)
        self._commands = True
        self.datagrams.send(packet, self._robot)

    def close(self) -> None:
        """Tell a robot that was commanded to hold its posture, some copies of it, and let go."""
        if self._closed:
            return
        self._closed = True
        if self._commands:
            farewell = RobotCommand(self._last_t, CommandMode.HOLD, np.zeros(self.codec.model.na))
            for _ in range(FAREWELLS):
                self.write(farewell)
        self.datagrams.close()
