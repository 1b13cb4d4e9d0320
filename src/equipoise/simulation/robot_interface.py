"""What stands between controller and engine: sensors, faults, and the supervisor of the law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.control import (
    Command,
    Measurement,
    Mode,
    PassivityController,
    Supervisor,
    Target,
)
from equipoise.errors import NameNotFoundError
from equipoise.physics import PhysicsState
from equipoise.robots import Robot
from equipoise.runlog import Channel
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path, frame_of
from equipoise.simulation.faults import FaultInjector, Faults, Push
from equipoise.simulation.sensors import Reading, SensorModel, SensorModels, SensorSuite, Silence
from equipoise.spatial import Array

MODE_CODES = {Mode.RUN: 0.0, Mode.DEGRADED: 1.0, Mode.SAFE: 2.0, Mode.STOPPED: 3.0}


@dataclass
class _Tick:
    """What the present tick logs."""

    reading: Reading | None = None
    applied: Array | None = None


class SimulatedRobot:
    """Sensors, faults and supervisor of a run; seeded by the scenario."""

    def __init__(
        self,
        scenario: schema.Scenario,
        robot: Robot,
        contacts: ContactStack,
        controller: PassivityController,
    ) -> None:
        dt = scenario.control.period
        self.robot, self.contacts, self.controller = robot, contacts, controller
        try:
            self.sensors = SensorSuite(robot, contacts, _models(scenario), dt, scenario.seed)
        except NameNotFoundError as error:
            raise at_path(error, "faults.silences") from None
        self.faults = FaultInjector(robot, _faults(scenario, robot), dt, scenario.seed + 1)
        control = scenario.control
        self.supervisor = Supervisor(
            controller,
            filter_time=control.reaction_filter,
        )
        self._command: Command | None = None
        self._rows: dict[ContactStack, Array] = {}
        self._tick = _Tick()
        self._logs_readings = scenario.sensors != schema.SensorsSpec() or bool(
            scenario.faults.silences or scenario.faults.measurement_delay
        )

    @property
    def story(self) -> tuple[str, ...]:
        """Every change of the mode, and what soles were about to do, in sentences."""
        notes = self.supervisor.notes
        near = (f"t = {t:.3f} s: {what}, if it goes on like this" for what, t in notes.items())
        return (*(str(change) for change in self.supervisor.changes), *near)

    def control(self, t: float, state: PhysicsState, target: Target) -> Command:
        """Return the command at time `t` [s]: measured, supervised, perhaps a tick too late."""
        reading = self.faults.late_reading(self.sensors.read(state))
        self._tick.reading = reading
        if self._command is not None and self.faults.tick_is_missed():
            return self._command
        held = reading.lam[self._rows_of(self.controller.contacts)]
        measured = Measurement(reading.q, reading.v, held)
        self._command = self.supervisor.step(t, measured, target)
        return self._command

    def _rows_of(self, held: ContactStack) -> Array:
        """Return where the rows of the contacts that hold are among those of all (k,)."""
        rows = self._rows.get(held)
        if rows is None:
            parts = [np.r_[self.contacts.rows[contact.name]] for contact in held.contacts]
            rows = self._rows[held] = np.concatenate([np.zeros(0, dtype=int), *parts])
        return rows

    def applied(self, command: Command) -> Array:
        """Return the torque (na,) [N m] that the motors give to a command now."""
        self._tick.applied = self.faults.torque(command.tau)
        return self._tick.applied

    @property
    def channels(self) -> list[Channel]:
        """What is logged besides: the mode; what was measured where it is not the truth."""
        doc = "0 run, 1 degraded, 2 safe: damping, 3 stopped"
        found = [Channel("mode", ("supervisor",), "", doc)]
        if self._logs_readings:
            robot = self.robot
            names = (*("x", "y", "z", "qx", "qy", "qz", "qw"), *robot.joint_names)
            units = (*("m",) * 3, *("",) * 4, *("rad",) * robot.na)
            found.append(Channel("measured/q", names, units, "configuration as measured"))
            units = (*("m/s",) * 3, *("rad/s",) * (robot.na + 3))
            found.append(Channel("measured/v", robot.velocity_names, units, "velocity as measured"))
            for contact in self.contacts.contacts:
                doc = "multiplier as measured"
                name = f"measured/lam/{contact.name}"
                found.append(Channel(name, contact.labels, contact.units, doc))
        if self.faults.faults != Faults():
            doc = "torques that the motors gave"
            found.append(Channel("applied", self.robot.joint_names, "N m", doc))
        return found

    def values(self) -> dict[str, Array]:
        """Return the logged values of the present tick."""
        values = {"mode": np.array([MODE_CODES[self.supervisor.mode]])}
        reading = self._tick.reading
        if self._logs_readings and reading is not None:
            values["measured/q"], values["measured/v"] = reading.q, reading.v
            for name, lam in self.contacts.split(reading.lam).items():
                values[f"measured/lam/{name}"] = lam
        if self.faults.faults != Faults() and self._tick.applied is not None:
            values["applied"] = self._tick.applied
        return values


def _models(scenario: schema.Scenario) -> SensorModels:
    kinds = {name: SensorModel(**values) for name, values in scenario.sensors.model_dump().items()}
    silences = tuple(
        Silence(one.sensor, one.start, np.inf if one.end is None else one.end, one.reading)
        for one in scenario.faults.silences
    )
    return SensorModels(**kinds, silences=silences)


def _faults(scenario: schema.Scenario, robot: Robot) -> Faults:
    spec = scenario.faults
    pushes = tuple(
        Push(
            frame_of(robot, one.frame, f"faults.pushes.{i}.frame"),
            (one.force[0], one.force[1], one.force[2]),
            one.start,
            one.duration,
        )
        for i, one in enumerate(spec.pushes)
    )
    return Faults(
        pushes,
        spec.measurement_delay,
        spec.command_delay,
        spec.missed_ticks,
        spec.torque_share,
    )
