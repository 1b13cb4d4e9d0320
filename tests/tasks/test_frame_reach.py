"""A frame that its target has left behind is drawn to it as a mass with a damper is."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.errors import InputError, ShapeError
from equipoise.hqp import Block, make_solver
from equipoise.motion import MotionGenerator, borne_inertia
from equipoise.motion.levels import polygon_of
from equipoise.robots import get_robot
from equipoise.spatial import pose
from equipoise.tasks import (
    ComPolygonTask,
    ContactTask,
    FramePoseTask,
    JointLimitsTask,
    PostureTask,
    Reach,
)
from equipoise.trajectories import FixedPose, Waypoint, WaypointTrajectory
from helpers import kinematics, sole_contacts

DT = 1e-3


def target_beside(robot, way):
    """Return the pose of the right palm at half-sitting, `way` [m] further forward."""
    T = robot.at(robot.q_half_sitting).placement("right_palm")
    return pin.SE3(T.rotation, T.translation + np.array([way, 0.0, 0.0]))


def test_a_frame_far_off_is_asked_for_no_more_than_its_pull(hrp2):
    far = FixedPose(pose((3.0, -1.0, 1.0), (0.0, 2.0, 0.0)))
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    wanted = FramePoseTask("hand", "right_palm", far).rows(kin, 0.0).lower
    reach = Reach(hrp2, DT, pull=0.3, pull_turn=0.5)
    asked = FramePoseTask("hand", "right_palm", far, reach=reach).rows(kin, 0.0).lower
    for part, most in ((slice(0, 3), 0.3), (slice(3, 6), 0.5)):
        length = np.linalg.norm(wanted[part])
        assert length > most
        np.testing.assert_allclose(asked[part], wanted[part] * most / length, rtol=1e-12)


@pytest.mark.parametrize("dt", [1e-3, 4e-3])
def test_the_rows_of_a_frame_behind_are_a_mass_and_a_damper(hrp2, rng, dt):
    """Their least squares is the minimum of the cost that is written down, found independently."""
    v_before = 0.1 * rng.normal(size=hrp2.nv)
    weights = rng.uniform(1.0, 5.0, size=hrp2.na)
    reach = Reach(hrp2, dt, damping=0.3, mass=0.02, weights=weights)
    task = FramePoseTask("hand", "right_palm", FixedPose(target_beside(hrp2, 1.0)), reach=reach)
    kin = hrp2.at(hrp2.q_half_sitting, v_before)
    rows = task.rows(kin, 0.0)
    np.testing.assert_array_equal(rows.lower, rows.upper)
    found = np.linalg.lstsq(rows.A, rows.lower, rcond=None)[0]
    J, p = rows.A[:6], rows.lower[:6]
    D, m = np.diag(0.3**2 * weights**2), np.diag(0.02 / dt * weights**2)
    H, g = J.T @ J, J.T @ p
    H[6:, 6:] += D + m
    g[6:] += m @ v_before[6:]
    np.testing.assert_allclose(found, np.linalg.solve(H, g), atol=1e-8)


def test_near_its_target_only_changes_of_speed_are_bounded(hrp2, rng):
    v_before = 0.1 * rng.normal(size=hrp2.nv)
    target = FixedPose(target_beside(hrp2, 0.01))
    kin = hrp2.at(hrp2.q_half_sitting, v_before)
    task = FramePoseTask("hand", "right_palm", target, reach=Reach(hrp2, DT, change=8.0))
    rows, plain = task.rows(kin, 0.0), FramePoseTask("hand", "right_palm", target).rows(kin, 0.0)
    np.testing.assert_array_equal(rows.A[:6], plain.A)
    np.testing.assert_array_equal(rows.lower[:6], plain.lower)
    unit = rows.A[6:, 6:].diagonal()
    np.testing.assert_allclose(rows.lower[6:] / unit, v_before[6:] - 8.0 * DT, atol=1e-14)
    np.testing.assert_allclose(rows.upper[6:] / unit, v_before[6:] + 8.0 * DT, atol=1e-14)
    block = Block(rows.name, rows.unit, rows.labels, 0, slice(0, len(rows.labels)))
    assert len(rows.labels) == len(task.describe(block, None)) == 6 + hrp2.na


def stretched(robot, dt, reach):
    """Return v_ref (n, nv) of an arm that is sent 1 m too far and called back."""
    q = robot.q_half_sitting
    here, far = target_beside(robot, 0.0), target_beside(robot, 1.5)
    way = [Waypoint(0.0, here), Waypoint(2.0, far, True), Waypoint(8.0, far, True)]
    target = WaypointTrajectory([*way, Waypoint(10.0, here)])
    contacts = sole_contacts(robot, q)
    balance = ComPolygonTask("balance", polygon_of(contacts), margin=0.03)
    levels = [
        [ContactTask("contacts", ContactStack(contacts))],
        [JointLimitsTask("limits", robot, rate=5.0), balance],
        [FramePoseTask("hand", "right_palm", target, reach=reach)],
        [PostureTask("posture", robot, q[7:])],
    ]
    motion = MotionGenerator(robot, levels, make_solver("active_set"), dt, q)
    v = np.array([motion.step(k * dt).v_ref for k in range(round(24.0 / dt))])
    return v, robot.at(motion.q_ref).placement("right_palm"), here


@pytest.mark.parametrize("name", ["hrp2", "g1"])
def test_an_arm_out_of_reach_comes_to_rest_and_comes_back(name):
    """Half the time step asks for no more acceleration; without a reach the velocity jumps."""
    robot, peaks = get_robot(name), {}
    weights = np.maximum(borne_inertia(robot, robot.q_half_sitting), 1.0) ** 0.75
    for dt in (0.004, 0.008):
        v, end, home = stretched(robot, dt, Reach(robot, dt, weights=weights))
        peaks[dt] = np.abs(np.diff(v, axis=0)).max() / dt
        at_rest = v[round(7.5 / dt) : round(8.0 / dt), 6:]
        assert np.abs(at_rest).max() < 0.2
        assert np.linalg.norm(end.translation - home.translation) < 1e-3
    assert peaks[0.004] < 1.2 * peaks[0.008]
    for dt in peaks:
        v, _, _ = stretched(robot, dt, None)
        assert np.abs(np.diff(v, axis=0)).max() > np.abs(robot.v_max).min()


@pytest.mark.parametrize("wrong", [{"mass": 0.0}, {"pull": -1.0}, {"damping": -0.1}])
def test_a_reach_that_is_none_is_refused(hrp2, wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        Reach(hrp2, DT, **wrong)


def test_a_reach_for_other_joints_is_refused(hrp2):
    with pytest.raises(ShapeError):
        Reach(hrp2, DT, weights=np.ones(3))
    with pytest.raises(InputError, match="fastest"):
        Reach(hrp2, DT, fastest=np.zeros(hrp2.na))
    with pytest.raises(InputError, match="must be a Robot"):
        Reach("hrp2", DT)
