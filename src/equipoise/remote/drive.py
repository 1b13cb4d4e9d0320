"""A run whose robot is behind a wire: the controller, and what is logged of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import monotonic, perf_counter_ns

import numpy as np
import pinocchio as pin

from equipoise.errors import ScenarioError
from equipoise.estimation import EstimatingRobot
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics import PhysicsState
from equipoise.remote.pace import Clock, Due, Lockstep, Pace, RealTime, require_driven
from equipoise.remote.ramp_out import RampOut
from equipoise.remote.walking import FarSoles, come_to_feet, walk_of
from equipoise.runlog import Channel, TickRecord
from equipoise.scenarios import schema
from equipoise.simulation.build.assemble import Controls, Prepared, assemble_controls
from equipoise.simulation.controlled_run import ControlledRun
from equipoise.simulation.held_rows import HeldRows
from equipoise.simulation.operator import StopRequested
from equipoise.simulation.recorder import Recorder
from equipoise.simulation.sensors import Reading
from equipoise.spatial import Array
from equipoise.wbc import WholeBodyCommand
from equipoise.wire.health import HOTTEST_AT_START, told_of_health, trouble
from equipoise.wire.interface import (
    CommandMode,
    RobotCommand,
    RobotInterface,
    RobotLostError,
    RobotMode,
    RobotState,
)
from equipoise.wire.model import WireModel

MEETING = 20.0  # [s] that a robot is waited for
NEAR = 0.05  # [rad, m] from the starting posture in which a robot may be met
NO_PUSH = "a push of a person cannot be sent to this robot and was left out"

Connect = Callable[[Controls, WireModel], RobotInterface]


class RemoteRun(ControlledRun):
    """Drives the robot that `connect` gives, through a scenario.

    What is logged is what was measured: where a sensor says nothing, its last value. Contacts that
    are pushed along cannot be followed, for nothing measures how far they have gone; nor can feet
    walk below a base that is estimated from feet that stand.
    Raises: `ScenarioError`, `PostureNotFoundError`.
    """

    def __init__(
        self,
        scenario: schema.Scenario,
        connect: Connect,
        *,
        lockstep: bool,
        prepared: Prepared | None = None,
        clock: Clock = monotonic,
    ) -> None:
        if scenario.world.sliders:
            raise ScenarioError(
                "nothing measures how far a pushed object has gone: not across a wire",
                path="world.sliders",
                given=sorted(scenario.world.sliders),
            )
        controls = assemble_controls(scenario, prepared)
        super().__init__(controls, Recorder(controls, {}))
        contacts = self.setup.contacts
        model = WireModel.of(self.robot, contacts, self.dt, lockstep=lockstep)
        self.link = connect(controls, model)
        self._pace: Pace = (Lockstep if lockstep else RealTime)(self.link, self.dt, clock)
        self._held = HeldRows(contacts)
        self._kinematics = KinematicsEvaluator(self.robot)
        self._first: RobotState | None = None
        self._nothing = [np.full(n, np.nan) for n in (self.robot.nq, self.robot.nv, contacts.size)]
        self._told: list[str] = []
        self.released: Callable[[], None] = _release_nothing  # is called when the robot was let go
        self._soles = FarSoles(contacts)
        self.walk = walk_of(controls, self._soles, self.link)
        stands = come_to_feet(self.walk) if self.walk is not None else None
        self.ramp_out = RampOut(self.controller, stands)
        if isinstance(self.link, EstimatingRobot):
            self.link.follows = self.controller.follows  # contacts come and go by its clock

    @property
    def happened(self) -> tuple[str, ...]:
        """What happened to the feet of a walk, in sentences."""
        return self.walk.story if self.walk is not None else ()

    @property
    def robot_channels(self) -> list[Channel]:
        """What is known of the wire."""
        doc = "age of the measured state, NaN where none had come; from its arrival to the command"
        found = [Channel("wire", ("age", "answer"), ("s", "s"), doc)]
        if isinstance(self.link, EstimatingRobot):
            doc = "standard deviations of the estimated base, by its filter"
            labels, units = ("position", "velocity", "angle"), ("m", "m/s", "rad")
            found.append(Channel("estimate", labels, units, doc))
        return found + (self.walk.channels if self.walk is not None else [])

    @property
    def story(self) -> tuple[str, ...]:
        """What a person changed, what the supervisor did and what was lost, in sentences."""
        lost = []
        if isinstance(self._pace, RealTime) and (self._pace.missed or self._pace.skipped):
            lost.append(
                f"{self._pace.missed} ticks had no state in time, {self._pace.skipped} were skipped"
            )
        ramped_out = [self.ramp_out.told] if self.ramp_out.told else []
        return (*super().story, *self._told, *lost, *ramped_out)

    def meet(self) -> list[str]:
        """Wait for the robot and look at it, commanding nothing; return what was found, in words.

        Raises: `RobotLostError` if there is none, or if it cannot begin here.
        """
        state = self._first = self.link.read(MEETING)
        if state is None:
            raise RobotLostError(
                f"No robot was heard within {MEETING:g} s. Start it first: equipoise plant"
            )
        require_driven(state)
        if state.mode is not RobotMode.WAITING:
            raise RobotLostError(
                "The robot is driven already; it can only be begun where it starts."
            )
        silent = [name for name, age in state.ages.items() if age > 0.0]
        if silent:
            raise RobotLostError(f"The robot does not measure: {', '.join(silent)}.")
        far = np.abs(pin.difference(self.robot.model, self.controls.q_start, state.q))
        worst = int(np.argmax(far))
        if not far[worst] <= NEAR:
            name = self.robot.velocity_names[worst]
            raise RobotLostError(
                f"The robot is not where the scenario starts: {name} is off by {far[worst]:.3f}."
            )
        names = self.robot.joint_names
        unfit = trouble(state.health, names, HOTTEST_AT_START)
        if unfit:
            raise RobotLostError(f"The robot is not fit to be driven: {unfit}.")
        name = self.robot.velocity_names[worst]
        return [
            f"{self.robot.name} is heard and waits; names, limits, contacts and period agree",
            f"it stands where it should, {1e3 * far[worst]:.2g} mm or mrad off at most ({name})",
            *told_of_health(state.health, names),
        ]

    def tell(self, sentence: str) -> None:
        """Add a sentence to the story, once."""
        if sentence not in self._told:
            self._told.append(sentence)

    def close(self) -> None:
        """Let go of the robot, which then holds its posture by itself."""
        self.link.close()
        self.released()

    def ticks(self, record: TickRecord | None = None) -> Iterator[tuple[float, TickRecord]]:
        """Run; yield time and record of each tick. `lam` acts during the tick.

        Raises: `RobotLostError`, `StopRequested`.
        """
        record = record or TickRecord(self.channels)
        self.recorder.write_into(record)
        try:
            if self._first is None:
                self.meet()
            assert self._first is not None
            if self.scenario.control.start == "standing":
                self.controller.take_over(self._first.tau)
            self._warm_up(self._first)
            yield from self._drive(Due(0, self._first), record)
        finally:
            self.close()

    def _drive(self, due: Due, record: TickRecord) -> Iterator[tuple[float, TickRecord]]:
        """Answer first, record then: a tick is whole once the next state tells its forces."""
        assert due.state is not None
        seen, heard = self._seen(due.state, None), due.state.t
        open_since: float | None = None  # time of the tick that is recorded but for that
        while due.tick < self.steps:
            k, t, arrived = due.tick, due.tick * self.dt, perf_counter_ns()
            try:
                self._may_go_on(t, due.state, seen)
            except (RobotLostError, StopRequested):
                if open_since is not None:
                    yield self._completed(open_since, seen, record)
                raise
            self._lead(t, seen)
            command = self._command(t, due.state)
            answer = RobotCommand(heard, CommandMode.TORQUE, command.tau)
            self.link.write(answer)
            answered = perf_counter_ns()
            if open_since is not None:
                yield self._completed(open_since, seen, record)
            age = t - heard if due.state is not None else np.nan
            self._begin_record(t, seen, command, record)
            record["wire"][:] = age, 1e-9 * (answered - arrived)
            open_since, before = t, seen
            due = self._pace.next(k, answer)
            if due.state is not None:
                state = due.state._replace(lam=self._soles.seen(due.state.lam))
                due, seen, heard = Due(due.tick, state), self._seen(state, before), state.t
            self.tick_ns[k] = answered - arrived, perf_counter_ns() - answered
            for skipped in range(k + 1, min(due.tick, self.steps)):
                yield self._completed(open_since, seen, record)
                open_since = skipped * self.dt
                self._lead(open_since, seen)
                command = self.controller.hold(open_since, command)
                self._begin_record(open_since, before, command, record)
                record["wire"][:] = np.nan
        if open_since is not None:
            yield self._completed(open_since, seen, record)

    def _may_go_on(self, t: float, state: RobotState | None, seen: PhysicsState) -> None:
        """Ask robot and people before a tick. Raises: `RobotLostError`, `StopRequested`."""
        if state is not None:
            self._require_fit(state)
        self._ask(t, seen)
        self.ramp_out.before_tick(t, seen.v)

    def _require_fit(self, state: RobotState) -> None:
        """Refuse to drive on a robot that says it must not be. Raises: `RobotLostError`."""
        unfit = trouble(state.health, self.robot.joint_names)
        if unfit:
            raise RobotLostError(f"The robot was let go at t = {state.t:.3f} s: {unfit}.")

    def _warm_up(self, state: RobotState) -> None:
        """Go through all that a tick may need, so that no kernel is loaded while a robot waits."""
        controller, changes = self.controller, self.controller.supervisor.changes
        memory, told = controller.state(), len(changes)
        seen = self._seen(state, None)
        for _ in range(3):
            command = self._command(0.0, state)
            self.recorder.write(0.0, seen, command, seen)
            self.recorder.correct(seen._replace(violation=self._violation(0.0, seen.q)))
            command = controller.hold(0.0, command)
        for t in np.linspace(0.0, 2.0 * controller.supervisor.limits.patience, 5):
            self._command(float(t), None)
        controller.restore(memory)
        del changes[told:]

    def _lead(self, t: float, seen: PhysicsState) -> None:
        """Lead the targets of a walk to time `t` [s]."""
        if self.walk is not None:
            self.walk.before_tick(t, Reading(seen.q, seen.v, seen.lam))

    def _command(self, t: float, state: RobotState | None) -> WholeBodyCommand:
        """Return the command at time `t` [s], on a state or on nothing."""
        q, v, lam = self._nothing
        if state is not None:
            q, v, lam = state.q, state.v, state.lam
        held = self._held.rows(self.controller.supports.at(self.controller.follows(t)))
        return self.controller.step(t, q, v, lam[held])

    def _ask(self, t: float, seen: PhysicsState) -> None:
        if self.operator_port is None:
            return
        try:
            if self.operator_port.before_tick(t, seen) is not None:
                self.tell(NO_PUSH)
        except StopRequested:
            self.ramp_out.ask("a person ended it")

    def _seen(self, state: RobotState, before: PhysicsState | None) -> PhysicsState:
        """Return a state for the log: what is missing is as it was. Its violation is not known."""
        parts = state.q, state.v, state.lam
        if before is not None:
            last = before.q, before.v, before.lam
            parts = tuple(
                np.where(np.isfinite(new), new, old) for new, old in zip(parts, last, strict=True)
            )  # type: ignore[assignment]
        q, v, lam = parts
        return PhysicsState(state.t, q, v, lam, np.nan)

    def _violation(self, t: float, q: Array) -> float:
        """Return how far a supporting contact has moved, by what is measured."""
        kin = self._kinematics.at(q, None, t)
        held = [c for c in self.controller.contacts.contacts if c.supporting]
        return max((float(np.abs(c.residual(kin)).max()) for c in held), default=0.0)

    def _begin_record(
        self, t: float, seen: PhysicsState, command: WholeBodyCommand, record: TickRecord
    ) -> None:
        """Write down a tick, all but the forces that act during it."""
        self.recorder.write(t, seen, command, seen)
        if isinstance(self.link, EstimatingRobot):
            record["estimate"][:] = self.link.base.spread
        if self.walk is not None:
            self.walk.write(record)

    def _completed(
        self, t: float, after: PhysicsState, record: TickRecord
    ) -> tuple[float, TickRecord]:
        """Complete the tick that was begun at time `t` [s]."""
        violation = self._violation(after.t, after.q)
        self.recorder.correct(after._replace(violation=violation))
        if self.operator_port is not None:
            self.operator_port.after_tick(t, record)
        return t, record


def _release_nothing() -> None:
    pass
