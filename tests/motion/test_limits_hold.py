"""Bounds on velocity in closed loop: a task that wants through them, at three time steps."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.collision.distances import DistanceEvaluator
from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import ContactStack, SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator, PostureNotFoundError, solve_posture
from equipoise.spatial import pose
from equipoise.tasks import (
    AvoidanceTask,
    ComPolygonTask,
    ContactTask,
    FramePoseTask,
    JointLimitsTask,
    PostureTask,
)
from equipoise.trajectories import FixedPose
from helpers import kinematics, sole_contacts

STEPS = [0.002, 0.01, 0.05]


def follow(robot, levels, dt, seconds):
    """Return the reference states of a run from half-sitting."""
    motion = MotionGenerator(robot, levels, make_solver("active_set"), dt, robot.q_half_sitting)
    return [motion.step(k * dt) for k in range(round(seconds / dt))]


def reach(robot, shift, rate=10.0):
    """Return a task that draws the left palm by `shift` from where it is at half-sitting."""
    frame_id = robot.frame_id("left_palm")
    T = kinematics(robot, robot.q_half_sitting).placement(frame_id)
    return FramePoseTask(
        "hand", frame_id, FixedPose(pin.SE3(T.rotation, T.translation + shift)), rate=rate
    )


def standing(robot):
    """Return the soles as level 0."""
    return ContactTask("contacts", ContactStack(sole_contacts(robot, robot.q_half_sitting)))


@pytest.mark.parametrize("dt", STEPS)
def test_joint_limits_hold_against_a_wild_posture(hrp2, dt):
    wild = PostureTask("wild", hrp2, hrp2.q_max + 1.0, rate=15.0)
    limits = JointLimitsTask("limits", hrp2, rate=10.0)
    for step in follow(hrp2, [[limits], [wild]], dt, 1.5):
        assert np.all(step.q_ref[7:] <= hrp2.q_max)
        assert np.all(step.q_ref[7:] >= hrp2.q_min)
        assert np.all(np.abs(step.v_ref[6:]) <= hrp2.v_max)
    assert np.abs(step.q_ref[7:] - limits.q_high).max() < 1e-3


@pytest.mark.parametrize("dt", STEPS)
def test_com_stays_inside_while_a_hand_pulls_out(hrp2, dt):
    contacts = sole_contacts(hrp2, hrp2.q_half_sitting)
    corners = np.vstack([sole_corners(c.sole, c.T_world_anchor) for c in contacts])
    polygon = SupportPolygon.of_points(corners)
    com = ComPolygonTask("com", polygon, margin=0.03, rate=3.0)
    far = reach(hrp2, np.array([0.8, 0.0, 0.0]), rate=2.0)
    posture = PostureTask("posture", hrp2, hrp2.q_half_sitting[7:])
    kept = follow(hrp2, [[standing(hrp2)], [com], [far], [posture]], dt, 2.0)
    free = follow(hrp2, [[standing(hrp2)], [far], [posture]], 0.01, 2.0)

    def least(steps):
        return min(polygon.margin(kinematics(hrp2, s.q_ref).p_world_com) for s in steps)

    # A velocity bound is met to first order in the step: allow the curvature of one step.
    assert least(kept) > 0.03 - 0.2 * dt
    assert least(free) < 0.0


@pytest.mark.parametrize("dt", STEPS)
def test_a_hand_sent_through_a_wall_stops_before_it(hrp2, dt):
    palm = kinematics(hrp2, hrp2.q_half_sitting).placement(hrp2.frame_id("left_palm")).translation
    wall = Body(
        "wall", (Shape("box", (0.05, 2.0, 3.0), pose((palm[0] + 0.25, 0, 0))),), pin.SE3.Identity()
    )
    scene = Scene(hrp2, [wall])
    pairs = [scene.pair(f"LARM_LINK{k}", "wall") for k in (3, 4, 5)]
    avoid = AvoidanceTask("wall", scene, pairs, influence=0.1, security=0.02, damping=0.5)
    through = reach(hrp2, np.array([0.4, 0.0, 0.2]), rate=5.0)
    limits = JointLimitsTask("limits", hrp2)
    posture = PostureTask("posture", hrp2, hrp2.q_half_sitting[7:])
    levels = [[standing(hrp2)], [limits, avoid], [through], [posture]]
    distances = DistanceEvaluator(scene, pairs)
    least = min(
        distances.at(kinematics(hrp2, s.q_ref)).min() for s in follow(hrp2, levels, dt, 2.0)
    )
    assert 0.02 - 0.1 * dt < least < 0.03


def test_contact_rows_make_the_projection_the_identity(hrp2):
    """(16) changes nothing once the contacts are level 0, but for the drift that is taken back."""
    stack = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    levels = [[ContactTask("contacts", stack)], [reach(hrp2, np.array([0.2, 0.1, 0.1]))]]
    for step in follow(hrp2, levels, 0.001, 0.1):
        kin = kinematics(hrp2, step.q_ref)
        stacked = stack.at(kin)
        correction = stacked.lift(-10.0 * stack.residual(kin))
        assert np.abs(stacked.project(step.v_ref) + correction - step.v_ref).max() < 1e-9


def test_a_posture_out_of_reach_names_the_task(hrp2):
    out_of_reach = reach(hrp2, np.array([2.0, 0.0, 0.0]))
    limits = JointLimitsTask("limits", hrp2)
    with pytest.raises(PostureNotFoundError, match="'hand': x is off"):
        solve_posture(
            hrp2,
            [[standing(hrp2)], [limits], [out_of_reach]],
            make_solver("active_set"),
            hrp2.q_half_sitting,
            t_from=0.0,
            must_hold=[out_of_reach],
        )
