"""What a run writes down: its channels, and their values at a tick."""

from __future__ import annotations

from collections.abc import Mapping

from equipoise.collision.scene import Pair
from equipoise.contacts import ReactionMargins, SoleContact
from equipoise.control import ControlStatus, Mode
from equipoise.errors import InputError
from equipoise.hqp import Status
from equipoise.motion.levels import polygon_of
from equipoise.physics import PhysicsState, PushedObject, PushedObjectState
from equipoise.robots import Robot
from equipoise.runlog import Channel, TickRecord
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path
from equipoise.simulation.build.assemble import Controls
from equipoise.simulation.build.setup import Setup
from equipoise.simulation.observer import Observer
from equipoise.tasks import AvoidanceTask, FramePoseTask, Task
from equipoise.trajectories import TravelTrajectory
from equipoise.wbc import WholeBodyCommand

CONTROL_CODES = {ControlStatus.RUN: 0.0, ControlStatus.SATURATED: 1.0, ControlStatus.HELD: 2.0}
HIERARCHY_CODES = {Status.SOLVED: 0.0, Status.ITERATION_LIMIT: 1.0, Status.FAILED: 2.0}
MODE_CODES = {mode: float(code) for code, mode in enumerate(Mode)}


class Recorder:
    """Writes what a tick produced into the views of a record.

    `sliders` are the pushed objects of the plant.
    """

    def __init__(
        self, controls: Controls, sliders: Mapping[PushedObject, PushedObjectState]
    ) -> None:
        scenario, setup, levels = controls.scenario, controls.setup, controls.levels
        self.setup, self.controller = setup, controls.controller
        self.pairs = monitored_pairs(scenario, setup, levels)
        self.channels = channels_of(scenario, setup, levels, self.pairs)
        self.tasks = [t for level in levels for t in level if isinstance(t, FramePoseTask)]
        self._observer = Observer(
            setup.scene, self.pairs, self.tasks, setup.contacts, setup.polygon
        )
        self._contacts, self._supports = self.controller.contacts, setup.soles.contacts
        self._wanted = [
            (contact.name, [self.controller.rows[f"{contact.name}/{r}"] for r in contact.regulated])
            for contact in setup.contacts.contacts
            if contact.regulated
        ]
        self._sliders = []
        for slider, state in sliders.items():
            spec = scenario.contacts[slider.contact]
            assert isinstance(spec, schema.PushContactSpec)
            target = setup.targets[spec.slider]
            assert isinstance(target, TravelTrajectory)
            self._sliders.append((f"slider/{spec.slider}", state, target.travel))

    def write_into(self, record: TickRecord) -> None:
        """Write into this record from now on."""
        self._observer.write_into(record)
        views = record.views
        self._violation, self._status = views["violation"], views["status"]
        self._mode, self._slack = views["mode"], views["slack"]
        self._wanted_views = [(name, views[f"lam_ref/{name}"], rows) for name, rows in self._wanted]
        self._slider_views = [
            (views[name], slider, travel) for name, slider, travel in self._sliders
        ]

    def write(
        self, t: float, state: PhysicsState, command: WholeBodyCommand, after: PhysicsState
    ) -> None:
        """Fill the record of a tick; multipliers are those that act during it."""
        if self.controller.contacts is not self._contacts:
            self._follow_supports()
        self._observer.look(
            self.controller.followed_at, state.q, state.v, command.result, after.lam
        )
        self._violation[0] = after.violation
        self._status[0] = CONTROL_CODES[command.status]
        self._status[1] = HIERARCHY_CODES[command.motion_status]
        self._mode[0] = MODE_CODES[command.mode]
        self.controller.motion.measure_levels(self._slack)
        if self._wanted_views:
            held, wanted = self.controller.contacts.rows, self.controller.wanted
            for name, view, rows in self._wanted_views:
                view[:] = wanted[rows] if name in held else 0.0
        for view, slider, travel in self._slider_views:
            view[:] = slider.travel, travel(t)[0]

    def correct(self, after: PhysicsState) -> None:
        """Put right in the record what only the next state tells: multipliers and violation."""
        self._observer.look_at_forces(after.lam)
        self._violation[0] = after.violation

    def _follow_supports(self) -> None:
        """Measure the balance on the contacts that support now, where they stand."""
        self._contacts = self.controller.contacts
        supports = tuple(c for c in self._contacts.contacts if c.supporting)
        if self.setup.polygon is None or list(map(id, supports)) == list(map(id, self._supports)):
            return
        self._supports = supports
        try:
            self._observer.stand_on(polygon_of(supports))
        except InputError:  # a line or a point: no polygon
            self._observer.stand_on(None)


def monitored_pairs(
    scenario: schema.Scenario, setup: Setup, levels: list[list[Task]]
) -> list[Pair]:
    """Return every pair that a task keeps apart or the scenario watches, each once."""
    pairs: dict[str, Pair] = {}
    for level in levels:
        for task in level:
            if isinstance(task, AvoidanceTask):
                pairs.update((pair.name, pair) for pair in task.pairs)
    for i, (first, second) in enumerate(scenario.monitor):
        try:
            pair = setup.scene.pair(first, second)
        except InputError as error:
            raise at_path(error, f"monitor.{i}") from None
        pairs.setdefault(pair.name, pair)
    return list(pairs.values())


def channels_of(
    scenario: schema.Scenario, setup: Setup, levels: list[list[Task]], pairs: list[Pair]
) -> list[Channel]:
    """Return the channels that a run of the scenario logs."""
    channels = [
        *_state_channels(setup.robot),
        Channel("com", ("x", "y", "z"), "m", "centre of mass, world axes"),
        Channel("com_margin", ("edge",), "m", "distance of the CoM projection to the polygon"),
        Channel("distance", tuple(p.name for p in pairs), "m", "distances of monitored pairs"),
        Channel("slack", tuple(f"level{i}" for i in range(len(levels))), "", "|w| of each level"),
        Channel("violation", ("largest",), "m or rad", "largest violation of a contact"),
        Channel(
            "status",
            ("control", "hierarchy"),
            "",
            "control: 0 run, 1 saturated, 2 held; hierarchy: 0 solved, 1 limit, 2 failed",
        ),
        Channel("mode", ("supervisor",), "", "0 run, 1 degraded, 2 safe, 3 stopped"),
    ]
    for contact in setup.contacts.contacts:
        name = contact.name
        channels.append(
            Channel(f"lam/{name}", contact.labels, contact.units, "multiplier, world on robot")
        )
        if contact.regulated:
            units = tuple(contact.units[contact.labels.index(r)] for r in contact.regulated)
            channels.append(
                Channel(f"lam_ref/{name}", contact.regulated, units, "wanted multiplier")
            )
        if isinstance(contact, SoleContact):
            channels.append(
                Channel(
                    f"margin/{name}",
                    ReactionMargins.LABELS,
                    ReactionMargins.UNITS,
                    "distance of the reaction to what a floor cannot give",
                )
            )
    for name in scenario.world.sliders:
        doc = "path of the pushed object, and the wanted one"
        channels.append(Channel(f"slider/{name}", ("travel", "wanted"), "m", doc))
    for level in levels:
        for task in level:
            if isinstance(task, FramePoseTask):
                channels.append(
                    Channel(f"error/{task.name}", task.labels, task.units, "task error, world axes")
                )
    return channels


def _state_channels(robot: Robot) -> list[Channel]:
    q_labels = (*robot.base_position_names, *robot.joint_names)
    q_units = (*robot.base_position_units, *("rad",) * robot.na)
    v_units = (*robot.base_velocity_units, *("rad/s",) * robot.na)
    dq_units = (*(unit.removesuffix("/s") for unit in robot.base_velocity_units),
                *("rad",) * robot.na)  # fmt: skip
    return [
        Channel("q", q_labels, q_units, "measured configuration, quaternion xyzw"),
        Channel("v", robot.velocity_names, v_units, "measured velocity, base in base axes"),
        Channel("q_ref", q_labels, q_units, "reference configuration"),
        Channel("v_ref", robot.velocity_names, v_units, "reference velocity"),
        Channel("tau", robot.joint_names, "N m", "commanded joint torques"),
        Channel("dq", robot.velocity_names, dq_units, "posture error q (-) q_ref"),
        Channel("s", robot.velocity_names, v_units, "extended error (21)"),
    ]
