"""What a run writes down: its channels, and their values at a tick."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pinocchio as pin

from equipoise.collision.distances import DistanceEvaluator
from equipoise.collision.scene import Pair
from equipoise.contacts import ReactionMargins, SoleContact, margins_of, outline
from equipoise.control import Command, ControlStatus
from equipoise.errors import InputError
from equipoise.hqp import Status
from equipoise.kinematics import KinematicsEvaluator
from equipoise.motion import MotionStep
from equipoise.physics import PhysicsState, PushedObject, PushedObjectState
from equipoise.runlog import Channel
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array
from equipoise.tasks import AvoidanceTask, FramePoseTask, Task

CONTROL_CODES = {ControlStatus.RUN: 0.0, ControlStatus.SATURATED: 1.0, ControlStatus.HELD: 2.0}
HIERARCHY_CODES = {Status.SOLVED: 0.0, Status.ITERATION_LIMIT: 1.0, Status.FAILED: 2.0}


class Recorder:
    """Turns what a tick produced into the values of its channels."""

    def __init__(
        self,
        scenario: schema.Scenario,
        setup: Setup,
        levels: list[list[Task]],
        wanted_forces: Mapping[str, list[Callable[[float], float]]],
        sliders: Mapping[PushedObject, PushedObjectState],
    ) -> None:
        self.scenario, self.setup = scenario, setup
        self.pairs = monitored_pairs(scenario, setup, levels)
        self.channels = channels_of(scenario, setup, levels, self.pairs)
        self._contacts = [
            (
                contact.name,
                setup.contacts.rows[contact.name],
                wanted_forces[contact.name],
                outline(contact.sole, contact.friction)
                if isinstance(contact, SoleContact)
                else None,
            )
            for contact in setup.contacts.contacts
        ]
        self._sliders = sliders
        self._kinematics = KinematicsEvaluator(setup.robot)
        self._distances = DistanceEvaluator(setup.scene, self.pairs)
        self._frame_tasks = [t for level in levels for t in level if isinstance(t, FramePoseTask)]

    def values(
        self,
        t: float,
        state: PhysicsState,
        motion: MotionStep,
        command: Command,
        after: PhysicsState,
    ) -> dict[str, Array]:
        """Return the logged values of a tick; multipliers are those that act during it."""
        kin = self._kinematics.at(state.q, state.v)
        com = kin.live_with_com.com.copy()
        values = {
            "q": state.q,
            "v": state.v,
            "q_ref": motion.q_ref,
            "v_ref": motion.v_ref,
            "tau": command.tau,
            "dq": pin.difference(self.setup.robot.model, motion.q_ref, state.q),
            "s": command.s,
            "com": com,
            "com_margin": np.array([self.setup.polygon.margin(com)]),
            "distance": self._distances.at(kin),
            "slack": np.array(motion.solution.slack),
            "violation": np.array([after.violation]),
            "status": np.array(
                [CONTROL_CODES[command.status], HIERARCHY_CODES[motion.solution.status]]
            ),
        }
        self._log_contacts(values, t, after)
        self._log_sliders(values, t)
        for task in self._frame_tasks:
            values[f"error/{task.name}"] = task.error(kin, t)
        return values

    def _log_contacts(self, values: dict[str, Array], t: float, after: PhysicsState) -> None:
        holding = self.setup.schedule.at(t).rows
        for name, rows, wanted, sole in self._contacts:
            lam = after.lam[rows]
            values[f"lam/{name}"] = lam
            if wanted:
                forces = [force(t) for force in wanted] if name in holding else [0.0] * len(wanted)
                values[f"lam_ref/{name}"] = np.array(forces)
            if sole is not None:
                values[f"margin/{name}"] = np.array(margins_of(lam, sole))

    def _log_sliders(self, values: dict[str, Array], t: float) -> None:
        for slider, state in self._sliders.items():
            spec = self.scenario.contacts[slider.contact]
            target = self.setup.targets[spec.slider]
            values[f"slider/{spec.slider}"] = np.array([state.travel, target.travel(t)[0]])


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
    robot = setup.robot
    q_labels = ("x", "y", "z", "qx", "qy", "qz", "qw", *robot.joint_names)
    q_units = ("m", "m", "m", "", "", "", "", *("rad",) * robot.na)
    v_units = (*("m/s",) * 3, *("rad/s",) * (robot.na + 3))
    dq_units = (*("m",) * 3, *("rad",) * (robot.na + 3))
    channels = [
        Channel("q", q_labels, q_units, "measured configuration, quaternion xyzw"),
        Channel("v", robot.velocity_names, v_units, "measured velocity, base in base axes"),
        Channel("q_ref", q_labels, q_units, "reference configuration"),
        Channel("v_ref", robot.velocity_names, v_units, "reference velocity"),
        Channel("tau", robot.joint_names, "N m", "commanded joint torques"),
        Channel("dq", robot.velocity_names, dq_units, "posture error q (-) q_ref"),
        Channel("s", robot.velocity_names, v_units, "extended error (21)"),
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
        doc = "way of the pushed object, and the wanted one"
        channels.append(Channel(f"slider/{name}", ("travel", "wanted"), "m", doc))
    for level in levels:
        for task in level:
            if isinstance(task, FramePoseTask):
                channels.append(
                    Channel(f"error/{task.name}", task.labels, task.units, "task error, world axes")
                )
    return channels
