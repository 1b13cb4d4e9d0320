"""Short closed-loop runs for certificates: recorded with everything that the proofs speak of."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.contacts import Contact, ContactStack, GraspContact, SoleContact
from equipoise.control import (
    Command,
    ControlGains,
    Measurement,
    PassivityController,
    Reference,
    advise_gains,
)
from equipoise.hqp import make_solver
from equipoise.kinematics import Kinematics
from equipoise.motion import MotionGenerator
from equipoise.physics import RigidContactEngine, RigidOptions
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import (
    ContactTask,
    FramePoseTask,
    PostureTask,
    Task,
)
from equipoise.trajectories import Waypoint, WaypointTrajectory

ReferencePath = Callable[[int], tuple[Array, Array]]


@dataclass(frozen=True)
class Sample:
    """One tick: what was measured and wanted, the law before and after it, what followed.

    `a_ref` (nv,) is how the wanted velocity goes on; `a` (nv,) and `lam` (r,) are those of (8) at
    this very instant under the commanded torque; `measured.lam` is the last one before it, which
    is what the law saw.
    """

    t: float
    measured: Measurement
    reference: Reference
    a_ref: Array
    before: PassivityController
    after: PassivityController
    command: Command
    a: Array
    lam: Array


@dataclass(frozen=True)
class Plan:
    """How a run goes: for `duration` [s] at period `dt` [s], under `gains` of `ControlGains`.

    `force` [N] is wanted on every regulated row; `kappa` [1/s] sets K_d = kappa M, by default the
    adviser's share of what the step allows; `dq_start` (nv,) displaces the start along tangent
    directions; a kick adds its dv (nv,) to the velocity at its tick, as a blow would; an event
    changes the memory of the law just before its tick. Every `keep_every`-th tick is kept, from
    the tick `keep_from` >= 1 on.
    """

    dt: float
    duration: float
    gains: Mapping[str, Any]
    force: float = 20.0
    kappa: float | None = None
    dq_start: Array | None = None
    joint_damping: float = 0.0
    kicks: Mapping[int, Array] = field(default_factory=dict)
    events: Mapping[int, Callable[[PassivityController], None]] = field(default_factory=dict)
    keep_every: int = 1
    keep_from: int = 1


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

    def right_inverse(self, J: Array) -> Array:
        """Return the inverse (nv, r) of `J` (r, nv) that goes with the law's projector, by numpy.

        `J^+`, or `K^-1 J^T (J K^-1 J^T)^-1` with K = K_d.
        """
        if self.gains.projector == "euclidean":
            return np.asarray(np.linalg.pinv(J), dtype=float)
        eased = np.linalg.solve(self.K_d, J.T)
        inverse = np.linalg.pinv(J @ eased, hermitian=True)
        return eased @ inverse

    def tangent(self, J: Array, x: Array) -> Array:
        """Return the part of `x` (nv,) that no row of `J` sees, by the same projector."""
        return x - self.right_inverse(J) @ (J @ x)

    def kinematics(self, sample: Sample) -> Kinematics:
        """Return the kinematics of the measured state of a sample."""
        state = sample.measured
        return self.robot.at(state.q, state.v, sample.t)


def standing_contacts(robot: Robot, *, grasp: bool, q: Array | None = None) -> ContactStack:
    """Return the soles, and the palms on an object between them, as they are at `q` (nq,)."""
    q_there = robot.q_half_sitting if q is None else q
    kin = robot.at(q_there)
    contacts: list[Contact] = [SoleContact.standing(sole, kin) for sole in robot.soles]
    if grasp:
        palms = (palm.frame for palm in robot.palms)
        contacts.append(GraspContact.holding("grasp", kin, *palms, regulated=("fz",)))
    return ContactStack(contacts)


def still_reference(robot: Robot) -> ReferencePath:
    """Return the reference that stays at half-sitting."""
    still = np.zeros(robot.nv)
    return lambda k: (robot.q_half_sitting, still)


def moving_reference(
    robot: Robot, contacts: ContactStack, dt: float, duration: float
) -> ReferencePath:
    """Return a palm that moves 10 cm forward and 8 cm up in 1 s, contacts kept.

    The hierarchy is solved for the first `duration` [s] of it.
    """
    palm = robot.palms[0].frame
    T = robot.at(robot.q_half_sitting).placement(palm)
    path = WaypointTrajectory(
        [
            Waypoint(0.0, T),
            Waypoint(1.0, pin.SE3(T.rotation, T.translation + np.array([0.10, 0.0, 0.08]))),
        ]
    )
    levels: list[list[Task]] = [
        [ContactTask("contacts", contacts)],
        [FramePoseTask("palm", palm, path)],
        [PostureTask("posture", robot, robot.q_half_sitting[robot.nq_base :])],
    ]
    motion = MotionGenerator(robot, levels, make_solver("active_set"), dt, robot.q_half_sitting)
    steps = [motion.step(k * dt) for k in range(round(duration / dt) + 1)]
    return lambda k: (steps[k].q_ref, steps[k].v_ref)


def record(
    robot: Robot, contacts: ContactStack, references: ReferencePath, plan: Plan
) -> RecordedRun:
    """Run the loop as planned, and keep what happened."""
    dt, gains = plan.dt, _gains(robot, contacts, plan)
    controller = PassivityController(robot, contacts, gains, dt)
    q_start = references(0)[0]
    if plan.dq_start is not None:
        q_start = pin.integrate(robot.model, q_start, plan.dq_start)
    run = RecordedRun(robot, contacts, gains, dt, plan.joint_damping)
    lam_ref = np.full(contacts.regulated_rows.size, plan.force)
    engine = _engine(run, q_start, np.zeros(robot.nv))
    state = engine.state
    for k in range(round(plan.duration / dt)):
        if k in plan.kicks:
            engine = _engine(run, state.q, state.v + plan.kicks[k])
            state = engine.state._replace(lam=state.lam)
        q_ref, v_ref = references(k)
        measured = Measurement(state.q, state.v, state.lam)
        reference = Reference(q_ref, v_ref, lam_ref)
        if k in plan.events:
            plan.events[k](controller)
        kept = k % plan.keep_every == 0 and k >= plan.keep_from
        before = snapshot(controller) if kept else controller
        command = controller.step(k * dt, measured, reference)
        if kept:
            a, lam = engine.accelerations(np.concatenate((np.zeros(robot.nv_base), command.tau)))
            after = snapshot(controller)
            a_ref = (references(k + 1)[1] - v_ref) / dt
            run.samples.append(
                Sample(k * dt, measured, reference, a_ref, before, after, command, a, lam)
            )
        state = engine.step(command.tau)
    return run


def _gains(robot: Robot, contacts: ContactStack, plan: Plan) -> ControlGains:
    alpha = float(plan.gains.get("alpha", 20.0))
    q = robot.q_half_sitting
    advice = advise_gains(robot, contacts, q, plan.dt, alpha=alpha, kappa=plan.kappa)
    return ControlGains(K_d=advice.K_d, **plan.gains)


def _engine(run: RecordedRun, q: Array, v: Array) -> RigidContactEngine:
    return RigidContactEngine(
        run.robot,
        run.contacts,
        q,
        run.dt,
        options=RigidOptions(joint_damping=run.joint_damping),
        v_start=v,
    )


def snapshot(controller: PassivityController) -> PassivityController:
    """Return a controller with the same memory, which steps without touching the original."""
    twin = PassivityController(
        controller.robot, controller.contacts, controller.gains, controller.dt
    )
    twin.restore(controller.state())
    return twin
