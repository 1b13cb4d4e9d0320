"""A scenario made ready to run: controller and plant wired, tick by tick."""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter_ns

from equipoise.physics import PhysicsState
from equipoise.runlog import Channel, TickRecord
from equipoise.scenarios import schema
from equipoise.simulation.build.assemble import Assembly, Prepared, assemble
from equipoise.simulation.build.leaning import build_leaning
from equipoise.simulation.controlled_run import ControlledRun
from equipoise.simulation.object_log import ObjectLog
from equipoise.simulation.recorder import Recorder
from equipoise.simulation.walk import WalkDriver
from equipoise.wbc import WholeBodyCommand


class Simulation(ControlledRun):
    """A run in one process: `ticks` runs it and yields what is logged.

    Building it finds the starting posture, unless it is `prepared`, so it takes a moment.
    Raises: `ScenarioError`, `PostureNotFoundError`.
    """

    def __init__(self, scenario: schema.Scenario, prepared: Prepared | None = None) -> None:
        self.assembly: Assembly = assemble(scenario, prepared)
        self.plant, self.engine = self.assembly.plant, self.assembly.engine
        super().__init__(self.assembly, Recorder(self.assembly, self.engine.sliders))
        self.objects = ObjectLog(self.engine)
        self.walk = self._walks(self.assembly)
        self._command: WholeBodyCommand | None = None

    def _walks(self, assembly: Assembly) -> WalkDriver | None:
        """Return what leads the walk, None where it stands."""
        walk, scenario, setup = assembly.walk, assembly.scenario, assembly.setup
        if walk is None:
            return None
        leaning = build_leaning(scenario, setup, assembly.levels, walk)
        return WalkDriver(walk, setup.robot, setup.contacts, self.controller, self.engine, leaning)

    @property
    def robot_channels(self) -> list[Channel]:
        """What the sensors and motors did, where loose objects are, how the walk goes."""
        walked = self.walk.channels if self.walk is not None else []
        return self.plant.channels + self.objects.channels + walked

    @property
    def happened(self) -> tuple[str, ...]:
        """What happened to the feet of a walk, in sentences."""
        return self.walk.story if self.walk is not None else ()

    def ticks(self, record: TickRecord | None = None) -> Iterator[tuple[float, TickRecord]]:
        """Run; yield time and record of each tick. `lam` acts during the tick.

        Without a `record` of these channels one is made; the next tick overwrites it.
        Raises: `DivergedError`, `StopRequested`.
        """
        state, port = self.engine.state, self.operator_port
        record = record or TickRecord(self.channels)
        self.recorder.write_into(record)
        for k in range(self.steps):
            t = k * self.dt
            pushed = port.before_tick(t, state) if port is not None else None
            began = perf_counter_ns()
            command = self._control(t, state)
            controlled = perf_counter_ns()
            after = self.plant.write(command.tau, state, pushed)
            self.tick_ns[k] = controlled - began, perf_counter_ns() - controlled
            self.recorder.write(t, state, command, after)
            self.plant.write_readings(record)
            self.objects.write(record)
            if self.walk is not None:
                self.walk.write(record)
            if port is not None:
                port.after_tick(t, record)
            yield t, record
            state = after

    def _control(self, t: float, state: PhysicsState) -> WholeBodyCommand:
        """Return the command at time `t` [s]: measured, supervised, perhaps a tick too late."""
        controller, plant = self.controller, self.plant
        reading = plant.read(state)
        if self.walk is not None:
            self.walk.before_tick(t, reading)
        if self._command is not None and plant.tick_is_missed():
            self._command = controller.hold(t, self._command)
            return self._command
        held = plant.multipliers(reading, controller.supports.at(t))
        self._command = controller.step(t, reading.q, reading.v, held)
        return self._command
