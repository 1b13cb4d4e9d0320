"""The plant: an engine behind sensors that err and motors that fail, read and written."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.physics import PhysicsEngine, PhysicsState
from equipoise.robots import Robot
from equipoise.runlog import Channel, TickRecord
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path, frame_of
from equipoise.simulation.faults import ExternalForce, FaultInjector, Faults
from equipoise.simulation.held_rows import HeldRows
from equipoise.simulation.sensors import (
    Reading,
    SensorModel,
    SensorModels,
    SensorSuite,
    Silence,
)
from equipoise.spatial import Array


class Plant:
    """What a controller sees of a plant: `read` what sensors show, `write` a torque.

    Seeded by the scenario: the same seed gives the same errors and faults.
    """

    def __init__(
        self,
        scenario: schema.Scenario,
        robot: Robot,
        contacts: ContactStack,
        engine: PhysicsEngine,
    ) -> None:
        dt = scenario.control.period
        self.robot, self.contacts, self.engine = robot, contacts, engine
        try:
            self.sensors = SensorSuite(robot, contacts, _models(scenario), dt, scenario.seed)
        except NameNotFoundError as error:
            raise at_path(error, "faults.silences") from None
        self.faults = FaultInjector(robot, _faults(scenario, robot), dt, scenario.seed + 1)
        self._held = HeldRows(contacts)
        self._reading: Reading | None = None
        self._applied: Array | None = None
        self._logs_applied = self.faults.faults != Faults()
        self._logs_readings = scenario.sensors != schema.SensorsSpec() or bool(
            scenario.faults.silences or scenario.faults.measurement_delay
        )

    def read(self, state: PhysicsState) -> Reading:
        """Return what arrives now of the sensors' readings; call it once a tick."""
        self._reading = self.faults.late_reading(self.sensors.read(state))
        return self._reading

    def tick_is_missed(self) -> bool:
        """Draw whether the controller comes too late this tick."""
        return self.faults.tick_is_missed()

    def multipliers(self, reading: Reading, held: ContactStack) -> Array:
        """Return the multipliers (k,) of the contacts that hold from a reading of all."""
        return reading.lam[self._held.rows(held)]

    def write(self, tau: Array, state: PhysicsState, pushed: Array | None) -> PhysicsState:
        """Let the motors give a torque for one period, and `pushed` (nv,) act besides.

        Raises: `DivergedError`.
        """
        self._applied = self.faults.torque(tau)
        for name in self.faults.vanished(state.t):
            self.engine.remove(name)
        external = self.faults.external(state.t, state.q, state.v)
        self.engine.external[:] = external if pushed is None else external + pushed
        return self.engine.step(self._applied)

    @property
    def channels(self) -> list[Channel]:
        """What is logged: what was measured and applied, where that is not the truth."""
        found = []
        if self._logs_readings:
            robot = self.robot
            names = (*robot.base_position_names, *robot.joint_names)
            units = (*robot.base_position_units, *("rad",) * robot.na)
            found.append(Channel("measured/q", names, units, "configuration as measured"))
            units = (*robot.base_velocity_units, *("rad/s",) * robot.na)
            found.append(Channel("measured/v", robot.velocity_names, units, "velocity as measured"))
            for contact in self.contacts.contacts:
                doc = "multiplier as measured"
                name = f"measured/lam/{contact.name}"
                found.append(Channel(name, contact.labels, contact.units, doc))
        if self._logs_applied:
            doc = "torques that the motors gave"
            found.append(Channel("applied", self.robot.joint_names, "N m", doc))
        return found

    def write_readings(self, record: TickRecord) -> None:
        """Fill the views of what was measured and applied in the present tick."""
        reading = self._reading
        if self._logs_readings and reading is not None:
            record["measured/q"][:], record["measured/v"][:] = reading.q, reading.v
            for name, rows in self.contacts.rows.items():
                record[f"measured/lam/{name}"][:] = reading.lam[rows]
        if self._logs_applied and self._applied is not None:
            record["applied"][:] = self._applied


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
        ExternalForce(
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
        _vanishing(scenario),
    )


def _vanishing(scenario: schema.Scenario) -> tuple[tuple[str, float], ...]:
    """Return which bodies vanish when. Raises: `ScenarioError`."""
    bodies, found = scenario.world.bodies, []
    for i, one in enumerate(scenario.faults.vanishing):
        if one.body not in bodies:
            raise at_path(
                NameNotFoundError("fixed body of the world", one.body, bodies),
                f"faults.vanishing.{i}.body",
            )
        found.append((one.body, one.at))
    stands = scenario.walk is None or scenario.physics.contacts == "bilateral"
    if found and scenario.physics.engine == "rigid" and stands:
        raise ScenarioError(
            "contacts that hold for ever notice nothing of a body that vanishes",
            path="faults.vanishing",
            remedy="Use the engine mujoco, or a walk",
        )
    return tuple(found)
