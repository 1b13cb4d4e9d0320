"""Rows of the motion: tasks (9)-(11), recursion (14), hierarchy (15), projection (16)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from equipoise.hqp import Hierarchy, make_solver
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks import FramePoseTask
from equipoise.trajectories import PoseTrajectory, Waypoint, WaypointTrajectory
from equipoise.verify.evidence import Evidence
from equipoise.verify.row import Check, Measured, worst

STEP = 1e-6


def _palm_task(evidence: Evidence, kin: Kinematics) -> tuple[FramePoseTask, PoseTrajectory]:
    """Return a palm that follows a moving pose, at the moment some centimetres off; its path."""
    palm = evidence.robot.palms[0].frame
    T = kin.placement(palm)
    start = T * pin.exp6(np.array([0.03, -0.02, 0.05, 0.1, 0.2, -0.1]))
    end = start * pin.exp6(np.array([0.1, 0.0, 0.05, 0.3, -0.2, 0.4]))
    path = WaypointTrajectory([Waypoint(-0.5, start), Waypoint(0.5, end)])
    return FramePoseTask("palm", palm, path, rate=7.0), path


def _task_error(evidence: Evidence) -> Measured:
    """(9): e = x_d - f(q) against the pose that the target has and the frame reaches."""
    errors = []
    for q, v in evidence.states:
        kin = evidence.at(q, v)
        task, path = _palm_task(evidence, kin)
        T_target = path.at(0.0).T_world_target
        e = task.error(kin, 0.0)
        T = kin.placement(task.frame)
        errors.append(T.translation + e[:3] - T_target.translation)
        errors.append(pin.exp3(e[3:]) @ T.rotation - T_target.rotation)
    return Measured(worst(errors), "f(q) moved by e is the target, in SE(3)")


def _task_rate(evidence: Evidence) -> Measured:
    """(10): any v that meets the rows makes e shrink at the rate alpha, the target moving."""
    model = evidence.robot.model
    errors: list[ArrayLike] = []
    for q, v in evidence.states:
        kin = evidence.at(q, v)
        task, _ = _palm_task(evidence, kin)
        rows = task.rows(kin, 0.0)
        solution = np.linalg.pinv(rows.A) @ rows.lower
        e = task.error(kin, 0.0)
        ends = []
        for s in (1, -1):
            moved = pin.integrate(model, q, s * STEP * solution)
            ends.append(task.error(evidence.at(moved, v), s * STEP))
        rate = (ends[0] - ends[1]) / (2 * STEP)
        errors.append(rate[:3] + task.rate * e[:3])
        # the rotation vector obeys it through its own length
        errors.append([e[3:] @ rate[3:] + task.rate * e[3:] @ e[3:]])
    return Measured(worst(errors), "de/dt = -alpha e by finite differences")


def _general_solution(evidence: Evidence) -> Measured:
    """(11): J^+ y + Q z meets J v = y for any z, and is the shortest for z = 0."""
    generator = evidence.generator()
    errors: list[ArrayLike] = []
    for q, v in evidence.states:
        stacked = evidence.contacts.at(evidence.at(q, v))
        y, z = generator.normal(size=len(stacked.J_phi)), generator.normal(size=len(v))
        solution = stacked.lift(y) + stacked.project(z)
        errors += [stacked.J_phi @ solution - y, [stacked.lift(y) @ stacked.project(z)]]
        errors.append(stacked.lift(y) - np.linalg.pinv(stacked.J_phi) @ y)
    return Measured(worst(errors), "random y and z")


def _recursion(evidence: Evidence) -> Measured:
    """(14): the recursion solver against the printed recursion with numpy's pseudo-inverse."""
    errors = []
    for step in evidence.tray[::40]:
        equal = _equalities(step.hierarchy)
        errors.append(make_solver("recursion").solve(equal).v - _printed_recursion(equal))
    return Measured(worst(errors), "equality rows of the tray, level by level")


def _equalities(hierarchy: Hierarchy) -> Hierarchy:
    """Return the equality rows alone, same levels."""
    keep = hierarchy.lower == hierarchy.upper
    counts = [int(keep[hierarchy.level(i)].sum()) for i in range(len(hierarchy.ends))]
    bounds = hierarchy.lower[keep]
    ends = tuple(int(end) for end in np.cumsum(counts))
    return Hierarchy(hierarchy.A[keep], bounds, bounds, ends, ())


def _printed_recursion(hierarchy: Hierarchy) -> Array:
    v, Q = np.zeros(hierarchy.n), np.eye(hierarchy.n)
    for i in range(len(hierarchy.ends)):
        rows = hierarchy.level(i)
        J, wanted = hierarchy.A[rows], hierarchy.lower[rows]
        if len(wanted):
            left = J @ Q  # rounding, where the levels above have used everything up
            least = 1e-9 * float(np.linalg.norm(J)) / max(float(np.linalg.norm(left, 2)), 1e-300)
            J_Q_pinv = np.linalg.pinv(left, rcond=min(least, 1.0))
            v = v + J_Q_pinv @ (wanted - J @ v)
            Q = Q - J_Q_pinv @ (J @ Q)
    return v


def _hierarchy(evidence: Evidence) -> Measured:
    """(15): how far each level is above its optimum, as a share of the size of its rows' values.

    By a certificate that knows no solver. A share, since rounding moves a row by a share of its
    size: rows of 10 m/s that are missed by 1e-8 m/s are met as well as they can be judged.
    """
    excess, active = 0.0, 0
    for step in evidence.tray[::5]:
        certificate = step.solution.certificate(step.hierarchy)
        for level in (*certificate.levels, certificate.least_norm):
            excess = max(excess, level.excess / level.scale if level.excess else 0.0)
        active = max(active, int((np.abs(step.solution.active) == 1).sum()))
    return Measured(excess, f"tray, up to {active} bounds active at once")


def _projection(evidence: Evidence) -> Measured:
    """(16): with the contacts as level 0 the projection changes nothing but drift correction."""
    errors = []
    for step in evidence.tray[::5]:
        J, v = step.J_phi, step.solution.v
        J_pinv = np.linalg.pinv(J)
        errors.append(v - J_pinv @ (J @ v) - (v - J_pinv @ step.contact_speed))
    return Measured(worst(errors), "Q v_ref against v_ref less its drift correction, tray")


CHECKS = (
    Check("(9)", "e leads from the frame to its target", "tasks.FramePoseTask.error", 1e-10,
          "m, -", _task_error),
    Check("(10)", "J v = target rate + alpha e makes e shrink at rate alpha",
          "tasks.FramePoseTask.rows", 1e-6, "m/s, rad2/s", _task_rate),
    Check("(11)", "J^+ y + Q z solves J v = y for any z", "contacts.StackedContacts.lift, .project",
          1e-9, "m/s, rad/s", _general_solution),
    Check("(14)", "the recursion of pseudo-inverses", "hqp.make_solver", 1e-7, "m/s, rad/s",
          _recursion),
    Check("(15)", "each level at its optimum, levels above kept", "hqp.make_solver", 1e-8,
          "-", _hierarchy),
    Check("(16)", "the projection changes nothing", "tasks.ContactTask, motion.MotionGenerator",
          1e-9, "m/s, rad/s", _projection),
)  # fmt: skip
