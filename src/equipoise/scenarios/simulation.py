"""A scenario made ready to run: motion generator, controller and engine wired, tick by tick."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from time import perf_counter_ns

import numpy as np
import pinocchio as pin

from equipoise.contacts import Contact, ReactionMargins, SoleContact, reaction_margins
from equipoise.control import (
    Command,
    ControlGains,
    ControlStatus,
    GainAdvice,
    Measurement,
    PassivityController,
    Profile,
    SignFunction,
    Target,
    advise_gains,
)
from equipoise.distances import DistanceEvaluator
from equipoise.hqp import Status, make_solver
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.motion import MotionGenerator, MotionStep, solve_posture
from equipoise.physics import PhysicsState, RigidContactEngine, Slider
from equipoise.robots import Robot
from equipoise.runlog import Channel
from equipoise.scenarios import schema
from equipoise.scenarios.levels import APPROACH_TIME, build_levels, build_start_levels
from equipoise.scenarios.places import Places, build_places, check_object
from equipoise.scenarios.steering import Helm, Steering
from equipoise.scenarios.wording import at_path, frame_of
from equipoise.spatial import Array
from equipoise.tasks import AvoidanceTask, FramePoseTask, Task
from equipoise.world import Pair

CONTROL_CODES = {ControlStatus.RUN: 0.0, ControlStatus.SATURATED: 1.0, ControlStatus.HELD: 2.0}
HIERARCHY_CODES = {Status.SOLVED: 0.0, Status.ITERATION_LIMIT: 1.0, Status.FAILED: 2.0}


class Simulation:
    """Everything of one run; `ticks` runs it and yields what is logged.

    Building it finds the starting posture, so it takes a moment.
    Raises: `ScenarioError`, `PostureNotFoundError`.
    """

    def __init__(self, scenario: schema.Scenario) -> None:
        self.scenario = scenario
        self.places = build_places(scenario)
        self.robot = self.places.robot
        self.levels = build_levels(scenario, self.places)
        self.pairs = _monitored_pairs(scenario, self.places, self.levels)
        self.q_start = self._starting_posture()
        self.advice = self._advice()
        self.wanted_forces = wanted_forces(scenario, self.places)
        self.dt = scenario.control.period
        self.steps = round(scenario.duration / self.dt)
        self.motion = MotionGenerator(
            self.robot, self.levels, make_solver(scenario.control.solver), self.dt, self.q_start
        )
        self.controller = PassivityController(
            self.robot,
            self.places.schedule.at(0.0),
            _gains(scenario.control.gains, self.advice),
            self.dt,
        )
        self.engine = self._engine()
        if scenario.control.start == "standing":
            self.controller.take_over(self.engine.stand())
        self.tick_ns = np.zeros((self.steps, 2), dtype=np.int64)
        self.helm: Helm | None = None
        self._measured_kinematics = KinematicsEvaluator(self.robot)
        self._distances = DistanceEvaluator(self.places.scene, self.pairs)
        self._frame_tasks = [
            t for level in self.levels for t in level if isinstance(t, FramePoseTask)
        ]

    def _starting_posture(self) -> Array:
        solver = make_solver(self.scenario.control.solver)
        q, t_from = self.robot.q_half_sitting, -APPROACH_TIME
        for with_avoidance in (False, True):
            levels = build_start_levels(self.scenario, self.places, with_avoidance=with_avoidance)
            must_hold = [t for level in levels for t in level if isinstance(t, FramePoseTask)]
            q = solve_posture(
                self.robot,
                levels,
                solver,
                q,
                t_from=t_from,
                must_hold=must_hold if with_avoidance else (),
                tolerance=1e-5 if with_avoidance else 1e-2,
            )
            t_from = 0.0
        return q

    def _advice(self) -> GainAdvice:
        gains = self.scenario.control.gains
        return advise_gains(
            self.robot,
            self.places.contacts,
            self.q_start,
            self.scenario.control.period,
            alpha=gains.alpha,
            kappa=gains.kappa,
        )

    def _engine(self) -> RigidContactEngine:
        physics = self.scenario.physics
        return RigidContactEngine(
            true_robot(self.scenario, self.places),
            self.places.contacts,
            self.q_start,
            self.dt,
            substeps=physics.substeps,
            position_gain=physics.position_gain,
            velocity_gain=physics.velocity_gain,
            joint_damping=physics.joint_damping,
            sliders=_sliders(self.scenario),
        )

    @property
    def channels(self) -> list[Channel]:
        """What every tick logs."""
        channels = _channels(self.scenario, self.places, self.levels, self.pairs)
        return channels + (self.helm.channels if self.helm is not None else [])

    def steer(self, steering: Steering) -> None:
        """Let someone change pushes, gains and wanted forces while it runs."""
        self.helm = Helm(self, steering)

    def ticks(self) -> Iterator[tuple[float, dict[str, Array]]]:
        """Run; yield time and logged values of each tick. `lam` acts during the tick.

        Raises: `DivergedError`, `StopRequested`.
        """
        state = self.engine.state
        for k in range(self.steps):
            t = k * self.dt
            if self.helm is not None:
                self.helm.before_tick(t, state)
            began = perf_counter_ns()
            motion = self.motion.step(t)
            command = self._control(t, state, motion)
            controlled = perf_counter_ns()
            after = self.engine.step(command.tau)
            self.tick_ns[k] = controlled - began, perf_counter_ns() - controlled
            values = self._logged(t, state, motion, command, after)
            if self.helm is not None:
                self.helm.after_tick(t, values)
            yield t, values
            state = after

    def _control(self, t: float, state: PhysicsState, motion: MotionStep) -> Command:
        contacts = self.places.schedule.at(t)
        if contacts is not self.controller.contacts:
            self.controller.switch(contacts)
        lam = self.places.contacts.split(state.lam)
        return self.controller.step(
            t,
            Measurement(state.q, state.v, np.concatenate([lam[c.name] for c in contacts.contacts])),
            Target(motion.q_ref, motion.v_ref, self._lam_ref(t, contacts.contacts)),
        )

    def _lam_ref(self, t: float, contacts: Sequence[Contact]) -> Array:
        return np.array([wanted(t) for c in contacts for wanted in self.wanted_forces[c.name]])

    def _logged(
        self,
        t: float,
        state: PhysicsState,
        motion: MotionStep,
        command: Command,
        after: PhysicsState,
    ) -> dict[str, Array]:
        kin = self._measured_kinematics.at(state.q, state.v)
        values = {
            "q": state.q,
            "v": state.v,
            "q_ref": motion.q_ref,
            "v_ref": motion.v_ref,
            "tau": command.tau,
            "dq": pin.difference(self.robot.model, motion.q_ref, state.q),
            "s": command.s,
            "com": kin.p_world_com,
            "com_margin": np.array([self.places.polygon.margin(kin.p_world_com)]),
            "distance": self._distances.at(kin),
            "slack": np.array(motion.solution.slack),
            "drift": np.array([after.drift]),
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
        holding = {contact.name for contact in self.places.schedule.at(t).contacts}
        for contact in self.places.contacts.contacts:
            lam = after.lam[self.places.contacts.rows[contact.name]]
            values[f"lam/{contact.name}"] = lam
            if contact.regulated:
                wanted = self._lam_ref(t, [contact])
                values[f"lam_ref/{contact.name}"] = wanted * (contact.name in holding)
            if isinstance(contact, SoleContact):
                margins = reaction_margins(lam, contact.sole, contact.friction)
                values[f"margin/{contact.name}"] = margins.as_array()

    def _log_sliders(self, values: dict[str, Array], t: float) -> None:
        for slider, state in self.engine.sliders.items():
            spec = self.scenario.contacts[slider.contact]
            target = self.places.targets[spec.slider]
            values[f"slider/{spec.slider}"] = np.array([state.travel, target.travel(t)[0]])

    def kinematics(self, q: Array) -> Kinematics:
        """Return the kinematics of the nominal robot at `q` (nq,), at rest."""
        return KinematicsEvaluator(self.robot).at(q, np.zeros(self.robot.nv))


def true_robot(scenario: schema.Scenario, places: Places) -> Robot:
    """Return the robot that is simulated: nominal, with the disturbances the law is not told."""
    disturbances = scenario.disturbances
    robot = places.robot
    if disturbances.mass_scale != 1.0:
        robot = robot.scaled(disturbances.mass_scale)
    for i, payload in enumerate(disturbances.payloads):
        path = f"disturbances.payloads.{i}"
        point = np.array(payload.at)
        if payload.object is not None:
            check_object(scenario, payload.object, f"{path}.object")
            frame = next(iter(scenario.world.objects[payload.object].handles))
            point = places.handles[payload.object, frame].actInv(point)
        else:
            frame = payload.frame or ""
            frame_of(robot, frame, f"{path}.frame")
        robot = robot.with_payload(frame, payload.mass, tuple(point))
    return robot


def _monitored_pairs(
    scenario: schema.Scenario, places: Places, levels: list[list[Task]]
) -> list[Pair]:
    pairs: dict[str, Pair] = {}
    for level in levels:
        for task in level:
            if isinstance(task, AvoidanceTask):
                pairs.update((pair.name, pair) for pair in task.pairs)
    for i, (first, second) in enumerate(scenario.monitor):
        try:
            pair = places.scene.pair(first, second)
        except Exception as error:
            raise at_path(error, f"monitor.{i}") from None
        pairs.setdefault(pair.name, pair)
    return list(pairs.values())


def wanted_forces(
    scenario: schema.Scenario, places: Places
) -> dict[str, list[Callable[[float], float]]]:
    """Return by contact the wanted multiplier of each regulated row as a function of time."""
    wanted: dict[str, list[Callable[[float], float]]] = {}
    for name, spec in scenario.contacts.items():
        if isinstance(spec, schema.GraspContactSpec):
            wanted[name] = [Profile.of(p.times, p.values).at for p in spec.regulated.values()]
        elif isinstance(spec, schema.SurfaceContactSpec):
            wanted[name] = [Profile.of(spec.force.times, spec.force.values).at]
        elif isinstance(spec, schema.PushContactSpec):
            wanted[name] = [_pushing_force(spec, scenario, places)]
        else:
            wanted[name] = []
    return wanted


def _pushing_force(
    spec: schema.PushContactSpec, scenario: schema.Scenario, places: Places
) -> Callable[[float], float]:
    profile = Profile.of(spec.force.times, spec.force.values)
    slider, target = scenario.world.sliders[spec.slider], places.targets[spec.slider]
    return lambda t: profile.at(t) + slider.viscosity * target.travel(t)[1]


def _sliders(scenario: schema.Scenario) -> list[Slider]:
    sliders = scenario.world.sliders
    return [
        Slider(name, sliders[spec.slider].coulomb, sliders[spec.slider].viscosity)
        for name, spec in scenario.contacts.items()
        if isinstance(spec, schema.PushContactSpec)
    ]


def _gains(spec: schema.GainsSpec, advice: GainAdvice) -> ControlGains:
    values = spec.model_dump(exclude={"kappa", "sgn_p", "sgn_F"})
    return ControlGains(
        K_d=advice.K_d,
        sgn_p=SignFunction(spec.sgn_p.kind, spec.sgn_p.layer),
        sgn_F=SignFunction(spec.sgn_F.kind, spec.sgn_F.layer),
        **values,
    )


def _channels(
    scenario: schema.Scenario, places: Places, levels: list[list[Task]], pairs: list[Pair]
) -> list[Channel]:
    robot = places.robot
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
        Channel("drift", ("largest",), "m or rad", "largest violation of a contact"),
        Channel(
            "status",
            ("control", "hierarchy"),
            "",
            "control: 0 run, 1 saturated, 2 held; hierarchy: 0 solved, 1 limit, 2 failed",
        ),
    ]
    for contact in places.contacts.contacts:
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
