"""Errata of the motion generation: the sign of (10) and the projection (16) afterwards."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.hqp import Hierarchy, Rows, make_solver
from equipoise.tasks import ContactTask, FramePoseTask, JointLimitsTask, PostureTask
from equipoise.trajectories import FixedPose
from helpers import kinematics, sole_contacts


@pytest.mark.parametrize("printed", [True, False])
def test_10_has_the_sign_of_the_error_s_own_jacobian(hrp2, printed):
    """`J qdot = -alpha e` with the Jacobian of f drives the hand away; `+` brings it home."""
    q, still = hrp2.q_half_sitting, np.zeros(hrp2.nv)
    frame_id = hrp2.frame_id(hrp2.palms[0].frame)
    T = kinematics(hrp2, q).placement(frame_id)
    target = pin.SE3(T.rotation, T.translation + np.array([0.05, 0.0, 0.03]))
    task = FramePoseTask("palm", frame_id, FixedPose(target), rate=5.0)
    before = np.linalg.norm(task.error(kinematics(hrp2, q), 0.0))
    for _ in range(20):
        rows = task.rows(kinematics(hrp2, q, still), 0.0)
        step = np.linalg.pinv(rows.A) @ rows.lower * (-1.0 if printed else 1.0)
        q = pin.integrate(hrp2.model, q, 0.01 * step)
    after = np.linalg.norm(task.error(kinematics(hrp2, q), 0.0))
    assert (after < before) is not printed


def crouching_with_a_stiff_ankle(hrp2):
    """Return tasks that want to crouch while an ankle is at its limit and the feet hold."""
    ankle, hip, knee = (hrp2.joint_index(f"LLEG_JOINT{i}") for i in (4, 2, 3))
    q = hrp2.q_half_sitting.copy()
    q[7 + ankle] = hrp2.q_min[ankle]
    goal = q[7:].copy()
    goal[hip] -= 0.3
    goal[knee] += 0.6
    contacts = ContactTask("contacts", ContactStack(sole_contacts(hrp2, q)))
    posture = PostureTask("posture", hrp2, goal, rate=1.0)
    return q, contacts, JointLimitsTask("limits", hrp2), posture


@pytest.mark.parametrize("printed", [True, False])
def test_16_projecting_afterwards_breaks_the_limits_just_enforced(hrp2, printed):
    """Limits hold in the answer of the hierarchy, and no longer in its projection.

    With the contacts as level 0 the limits hold together with them.
    """
    q, contacts, limits, posture = crouching_with_a_stiff_ankle(hrp2)
    kin = kinematics(hrp2, q)
    bounds = limits.rows(kin, 0.0)
    rows: list[list[Rows]] = [[bounds], [posture.rows(kin, 0.0)]]
    if not printed:
        rows.insert(0, [contacts.rows(kin, 0.0)])
    answer = make_solver("active_set").solve(Hierarchy.stack(rows, hrp2.nv)).v
    assert violation(bounds, answer) < 1e-9
    stacked = ContactStack(sole_contacts(hrp2, q)).at(kin)
    projected = stacked.project(answer)
    assert np.abs(stacked.J_phi @ projected).max() < 1e-10
    assert (violation(bounds, projected) < 1e-9) is not printed
    if printed:
        assert violation(bounds, projected) > 0.05
    else:
        assert np.allclose(projected, answer, atol=1e-9)


def violation(bounds: Rows, v: np.ndarray) -> float:
    """Return by how much the worst row [rad/s] is violated."""
    value = bounds.A @ v
    return float(np.maximum(value - bounds.upper, bounds.lower - value).max())
