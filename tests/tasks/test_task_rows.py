"""Rows of every task against finite differences of what the task says it controls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from equipoise.collision.distances import DistanceEvaluator
from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.hqp import Hierarchy, Rows, make_solver
from equipoise.spatial import pose
from equipoise.tasks import (
    AvoidanceTask,
    ComPolygonTask,
    ContactTask,
    FramePoseTask,
    JointLimitsTask,
    PostureTask,
)
from equipoise.trajectories import Waypoint, WaypointTrajectory
from helpers import kinematics, random_state, sole_contacts

STEP = 1e-6


def central(robot, q, v, t, value):
    """Return the rate of `value(kin, t)` along the motion q(t), v."""
    ahead = value(kinematics(robot, pin.integrate(robot.model, q, v * STEP)), t + STEP)
    behind = value(kinematics(robot, pin.integrate(robot.model, q, -v * STEP)), t - STEP)
    return (ahead - behind) / (2 * STEP)


@pytest.fixture
def way():
    first, last = pose((0.4, 0.1, 0.8), (0.1, 0.2, 0.3)), pose((0.6, -0.1, 0.9), (0.4, -0.3, 0.9))
    return WaypointTrajectory([Waypoint(0.0, first), Waypoint(2.0, last)])


def test_frame_pose_position_error_decays_at_its_rate(hrp2, rng, way):
    """With v that meets the rows, each error component shrinks with `rate` (small rotations)."""
    q, _ = random_state(hrp2, rng)
    frame_id = hrp2.frame_id("left_palm")
    here = kinematics(hrp2, q).placement(frame_id)
    near = here * pin.exp6(rng.normal(size=6) * 1e-3)
    goal = WaypointTrajectory([Waypoint(0.0, near), Waypoint(2.0, here)])
    task = FramePoseTask("hand", frame_id, goal, rate=7.0)
    rows = task.rows(kinematics(hrp2, q), 1.0)
    v = np.linalg.pinv(rows.A) @ rows.lower
    rate = central(hrp2, q, v, 1.0, task.error)
    assert np.allclose(rate, -7.0 * task.error(kinematics(hrp2, q), 1.0), atol=2e-5)


def test_com_rows_are_the_rate_of_the_room(hrp2, rng):
    q, v = random_state(hrp2, rng)
    contacts = sole_contacts(hrp2, hrp2.q_half_sitting)
    corners = np.vstack([sole_corners(c.sole, c.T_world_anchor) for c in contacts])
    polygon = SupportPolygon.of_points(corners)
    task = ComPolygonTask("com", polygon, margin=0.03, rate=4.0)
    rows = task.rows(kinematics(hrp2, q), 0.0)

    def room(kin, t):
        return polygon.offsets - polygon.normals @ kin.p_world_com[:2]

    assert np.allclose(rows.A @ v, -central(hrp2, q, v, 0.0, room), atol=1e-8)
    assert np.allclose(rows.upper, 4.0 * (room(kinematics(hrp2, q), 0.0) - 0.03))
    assert np.all(np.isinf(rows.lower))


def test_avoidance_rows_are_the_rate_of_the_distance(hrp2, rng):
    q, v = random_state(hrp2, rng, spread=0.05)
    desk = Body("desk", (Shape("box", (0.5, 1.0, 0.05), pose((0.55, 0, 0.7))),), pin.SE3.Identity())
    scene = Scene(hrp2, [desk])
    pairs = [
        scene.pair("LARM_LINK5", "desk"),
        scene.pair("LARM_LINK3", "LLEG_LINK2"),
        scene.pair("RARM_LINK4", "BODY"),
    ]
    task = AvoidanceTask("obstacles", scene, pairs, influence=2.0, security=0.02, damping=0.5)
    distances = DistanceEvaluator(scene, pairs)
    rows = task.rows(kinematics(hrp2, q), 0.0)
    rate = central(hrp2, q, v, 0.0, lambda kin, t: distances.at(kin))
    assert distances.at(kinematics(hrp2, q)).min() > 0.0
    assert np.allclose(rows.A[:3] @ v, rate, atol=1e-5)


def test_a_limb_turning_past_parallel_to_a_face_makes_no_jump(hrp2):
    """The nearest point leaps along the limb; with a row for each end the answer does not."""
    q = hrp2.q_half_sitting
    kin = kinematics(hrp2, q)
    shape = next(g for g in hrp2.collision_model.geometryObjects if g.name.startswith("LARM_LINK3"))
    T_world_limb = kin.pin_data.oMi[shape.parentJoint] * shape.placement
    radius = shape.geometry.radius

    def answer(tilt, ends):
        T = T_world_limb * pose((radius + 0.03, 0.0, 0.0), (0.0, tilt, 0.0))
        plate = Body("plate", (Shape("box", (0.02, 1.0, 1.0), pose((0.0, 0.0, 0.0))),), T)
        scene = Scene(hrp2, [plate])
        pair = scene.pair("LARM_LINK3", "plate")
        task = AvoidanceTask("near", scene, [pair], influence=0.1, security=0.019, damping=0.1)
        rows = task.rows(kin, 0.0)
        if not ends:
            rows = replace(
                rows,
                labels=rows.labels[:1],
                A=rows.A[:1],
                lower=rows.lower[:1],
                upper=rows.upper[:1],
            )
        toward = -rows.A[1:].sum(axis=0) if ends else -task.rows(kin, 0.0).A[1:].sum(axis=0)
        wish = Rows("wish", "rad/s", hrp2.velocity_names, np.eye(hrp2.nv), toward, toward)
        return make_solver("active_set").solve(Hierarchy.stack([[rows], [wish]], hrp2.nv)).v

    jump = np.abs(answer(1e-3, True) - answer(-1e-3, True)).max()
    without = np.abs(answer(1e-3, False) - answer(-1e-3, False)).max()
    assert without > 0.05
    assert jump < 0.05 * without


def test_far_pairs_are_free(hrp2):
    scene = Scene(hrp2)
    pairs = [scene.pair("LARM_LINK5", "RARM_LINK5")]
    task = AvoidanceTask("self", scene, pairs, influence=0.05, security=0.02)
    rows = task.rows(kinematics(hrp2, hrp2.q_half_sitting), 0.0)
    assert np.all(np.isinf(rows.lower))
    assert not rows.A.any()


def test_posture_and_limits_pick_the_joints(hrp2, rng):
    q, v = random_state(hrp2, rng)
    kin = kinematics(hrp2, q)
    posture = PostureTask("posture", hrp2, hrp2.q_half_sitting[7:], rate=2.0).rows(kin, 0.0)
    limits = JointLimitsTask("limits", hrp2, margin=0.01, velocity_share=0.5, rate=9.0).rows(
        kin, 0.0
    )
    assert np.array_equal(posture.A @ v, v[6:])
    assert np.array_equal(limits.A @ v, v[6:])
    assert np.allclose(posture.lower, 2.0 * (hrp2.q_half_sitting[7:] - q[7:]))
    assert np.all(limits.upper <= 0.5 * hrp2.v_max + 1e-12)
    assert np.all(limits.upper <= 9.0 * np.maximum(hrp2.q_max - 0.01 - q[7:], -1e9) + 1e-12)


def test_contact_task_takes_drift_back(hrp2, rng):
    """Following the contact rows shrinks the residual of the soles at the given rate."""
    from equipoise.contacts import ContactStack

    stack = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    q = pin.integrate(hrp2.model, hrp2.q_half_sitting, rng.normal(size=hrp2.nv) * 1e-4)
    task = ContactTask("contacts", stack, rate=6.0)
    rows = task.rows(kinematics(hrp2, q), 0.0)
    v = np.linalg.pinv(rows.A) @ rows.lower
    residual = stack.residual(kinematics(hrp2, q))
    rate = central(hrp2, q, v, 0.0, lambda kin, t: stack.residual(kin))
    assert np.allclose(rate, -6.0 * residual, atol=1e-6)
    assert len(task.units) == len(task.labels) == 12
