"""Bounds that become active do not make the velocity jump or tremble: a wall, a joint limit."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import ContactStack
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.spatial import pose
from equipoise.tasks import AvoidanceTask, ContactTask, FramePoseTask, JointLimitsTask, PostureTask
from equipoise.trajectories import Waypoint, WaypointTrajectory
from helpers import kinematics, sole_contacts

STEPS = (0.004, 0.002)  # [s]
STILL = 0.1  # [rad/s^2] slower changes of speed have no sign


def reach_into_wall(robot, dt, margin):
    """Return v_ref (n, nv), and how many limits and distances were active at most.

    A hand is led up and through a wall in 1.5 s; `margin` [rad] of the joint limits.
    """
    q = robot.q_half_sitting
    frame = robot.frame_id("left_palm")
    palm = kinematics(robot, q).placement(frame)
    shape = Shape("box", (0.05, 2.0, 3.0), pose((palm.translation[0] + 0.25, 0.0, 0.0)))
    scene = Scene(robot, [Body("wall", (shape,), pin.SE3.Identity())])
    pairs = [scene.pair(f"LARM_LINK{k}", "wall") for k in (3, 4, 5)]
    way = WaypointTrajectory([Waypoint(0.0, palm), Waypoint(1.5, pose((0.3, 0.1, 0.35)) * palm)])
    levels = [
        [ContactTask("contacts", ContactStack(sole_contacts(robot, q)))],
        [
            JointLimitsTask("limits", robot, margin=margin),
            AvoidanceTask("wall", scene, pairs, influence=0.1, security=0.02),
        ],
        [FramePoseTask("hand", frame, way)],
        [PostureTask("posture", robot, q[7:])],
    ]
    motion = MotionGenerator(robot, levels, make_solver("active_set"), dt, q)
    v, most = [], {"limits": 0, "wall": 0}
    for k in range(round(2.0 / dt)):
        step = motion.step(k * dt)
        v.append(step.v_ref)
        for block in step.hierarchy.blocks:
            if block.name in most:
                active = int((np.abs(step.solution.active[block.rows]) == 1).sum())
                most[block.name] = max(most[block.name], active)
    return np.array(v), list(most.values())


@pytest.fixture(scope="module")
def runs(hrp2):
    return {dt: reach_into_wall(hrp2, dt, margin=0.05) for dt in STEPS}


def changes_of_sign(v: np.ndarray, dt: float) -> np.ndarray:
    """Return for each row how often its acceleration changes sign."""
    a = np.diff(v, axis=0) / dt
    signs = [np.sign(row[np.abs(row) > STILL]) for row in a.T]
    return np.array([np.count_nonzero(np.diff(row)) for row in signs])


def test_wall_and_limit_do_become_active(runs):
    for _, (limits, distances) in runs.values():
        assert limits >= 1
        assert distances >= 1


def test_the_acceleration_does_not_depend_on_the_time_step(runs):
    """A velocity that jumps has an acceleration that doubles when the step is halved."""
    largest = [np.abs(np.diff(v, axis=0)).max() / dt for dt, (v, _) in runs.items()]
    assert largest[1] < 1.2 * largest[0]


def test_no_row_trembles(runs):
    """A hand that starts, is stopped and turned aside needs few changes of sign, at any step."""
    for dt, (v, _) in runs.items():
        assert changes_of_sign(v, dt).max() <= 6


def test_a_trembling_row_would_be_noticed(runs):
    v, _ = runs[STEPS[1]]
    shaken = v.copy()
    shaken[600::2, 9] += 1e-3
    assert changes_of_sign(shaken, STEPS[1]).max() > 100
