"""Short closed-loop runs for certificates: recorded with everything that the proofs speak of."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from equipoise.contacts import Contact, ContactStack, GraspContact, SoleContact
from equipoise.control import (
    Command,
    ControlGains,
    Measurement,
    PassivityController,
    Target,
    advise_gains,
)
from equipoise.hqp import make_solver
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.motion import MotionGenerator
from equipoise.physics import RigidContactEngine
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import ContactTask, FramePoseTask, PostureTask, Waypoint, WaypointTrajectory

Reference = Callable[[int], tuple[Array, Array]]


@dataclass(frozen=True)
class Sample:
    """One tick: what was measured and wanted, the law before and after it, what followed.

    `a_ref` (nv,) is how the wanted velocity goes on; `a` (nv,) and `lam` (r,) are those of (8) at
    this very instant under the commanded torque; `measured.lam` is the last one before it, which
    is what the law saw.
    """

    t: float
    measured: Measurement
    target: Target
    a_ref: Array
    before: PassivityController
    after: PassivityController
    command: Command
    a: Array
    lam: Array


@dataclass
class RecordedRun:
    """A closed-loop run: its parts, all references, and the samples that were kept."""

    robot: Robot
    contacts: ContactStack
    gains: ControlGains
    dt: float
    joint_damping: float
    samples: list[Sample] = field(default_factory=list)

    @property
    def K_d(self) -> Array:
        """The damping matrix of the law (nv, nv)."""
        return self.gains.damping_matrix(self.robot.nv)

    def kinematics(self, sample: Sample) -> Kinematics:
        """Return the kinematics of the measured state of a sample."""
        state = sample.measured
        return KinematicsEvaluator(self.robot).at(state.q, state.v, sample.t)


def standing_contacts(robot: Robot, *, grasp: bool, q: Array | None = None) -> ContactStack:
    """Return the soles, and the palms on an object between them, as they are at `q` (nq,)."""
    q_there = robot.q_half_sitting if q is None else q
    kin = KinematicsEvaluator(robot).at(q_there, np.zeros(robot.nv))
    contacts: list[Contact] = [SoleContact.standing(sole, kin) for sole in robot.soles]
    if grasp:
        palms = (palm.frame for palm in robot.palms)
        contacts.append(GraspContact.holding("grasp", kin, *palms, regulated=("fz",)))
    return ContactStack(contacts)


def still_reference(robot: Robot) -> Reference:
    """Return the reference that stays at half-sitting."""
    still = np.zeros(robot.nv)
    return lambda k: (robot.q_half_sitting, still)


def moving_reference(robot: Robot, contacts: ContactStack, dt: float, duration: float) -> Reference:
    """Return a palm on its way 10 cm forward and 8 cm up in 1 s, contacts kept.

    The hierarchy is solved for the first `duration` [s] of it.
    """
    frame_id = robot.frame_id(robot.palms[0].frame)
    kin = KinematicsEvaluator(robot).at(robot.q_half_sitting, np.zeros(robot.nv))
    T = kin.placement(frame_id)
    way = WaypointTrajectory(
        [
            Waypoint(0.0, T),
            Waypoint(1.0, pin.SE3(T.rotation, T.translation + np.array([0.10, 0.0, 0.08]))),
        ]
    )
    levels = [
        [ContactTask("contacts", contacts)],
        [FramePoseTask("palm", frame_id, way)],
        [PostureTask("posture", robot, robot.q_half_sitting[7:])],
    ]
    motion = MotionGenerator(robot, levels, make_solver("active_set"), dt, robot.q_half_sitting)
    steps = [motion.step(k * dt) for k in range(round(duration / dt) + 1)]
    return lambda k: (steps[k].q_ref, steps[k].v_ref)


def record(
    robot: Robot,
    contacts: ContactStack,
    reference: Reference,
    *,
    dt: float,
    duration: float,
    gains: dict[str, object],
    force: float = 20.0,
    kappa: float | None = None,
    dq_start: Array | None = None,
    keep_every: int = 1,
    keep_from: int = 1,
    joint_damping: float = 0.0,
    kicks: Sequence[tuple[int, Array]] = (),
    events: Mapping[int, Callable[[PassivityController], None]] | None = None,
) -> RecordedRun:
    """Run the loop for `duration` [s] at period `dt` [s].

    Every `keep_every`-th tick is kept, from the tick `keep_from` >= 1 on. `force` [N] is wanted on
    every regulated row; `kappa` [1/s] sets K_d = kappa M, by default the adviser's share of what
    the step allows; `dq_start` (nv,) displaces the start along tangent directions; a kick (tick,
    dv) adds `dv` (nv,) to the velocity, as a blow would; an event changes the memory of the law
    just before a tick.
    """
    alpha = float(gains.get("alpha", 20.0))  # type: ignore[arg-type]
    K_d = advise_gains(robot, contacts, robot.q_half_sitting, dt, alpha=alpha, kappa=kappa).K_d
    settings = ControlGains(K_d=K_d, **gains)  # type: ignore[arg-type]
    controller = PassivityController(robot, contacts, settings, dt)
    q_start = reference(0)[0]
    if dq_start is not None:
        q_start = pin.integrate(robot.model, q_start, dq_start)
    run = RecordedRun(robot, contacts, settings, dt, joint_damping)
    blows = dict(kicks)
    lam_ref = np.full(contacts.regulated_rows.size, force)
    engine = _engine(run, q_start, np.zeros(robot.nv))
    state = engine.state
    for k in range(round(duration / dt)):
        if k in blows:
            engine = _engine(run, state.q, state.v + blows[k])
            state = engine.state._replace(lam=state.lam)
        q_ref, v_ref = reference(k)
        measured = Measurement(state.q, state.v, state.lam)
        target = Target(q_ref, v_ref, lam_ref)
        if events and k in events:
            events[k](controller)
        kept = k % keep_every == 0 and k >= keep_from
        before = snapshot(controller) if kept else controller
        command = controller.step(k * dt, measured, target)
        if kept:
            a, lam = engine.accelerations(np.concatenate((np.zeros(6), command.tau)))
            after = snapshot(controller)
            a_ref = (reference(k + 1)[1] - v_ref) / dt
            run.samples.append(
                Sample(k * dt, measured, target, a_ref, before, after, command, a, lam)
            )
        state = engine.step(command.tau)
    return run


def _engine(run: RecordedRun, q: Array, v: Array) -> RigidContactEngine:
    return RigidContactEngine(
        run.robot, run.contacts, q, run.dt, v_start=v, joint_damping=run.joint_damping
    )


def snapshot(controller: PassivityController) -> PassivityController:
    """Return a controller with the same memory, which steps without touching the original."""
    twin = copy.copy(controller)
    twin.posture = copy.deepcopy(controller.posture)
    twin.force = copy.deepcopy(controller.force)
    return twin
