"""A floor that only pushes: rows of the momentum against Pinocchio and against Newton."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack, SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.tasks import (
    ComPolygonTask,
    ContactTask,
    FloorSupportTask,
    FramePoseTask,
    PostureTask,
)
from equipoise.trajectories import FixedPose
from helpers import random_state, sole_contacts

DT = 0.002


def polygon_of(robot):
    contacts = sole_contacts(robot, robot.q_half_sitting)
    points = np.vstack([sole_corners(c.sole, c.T_world_anchor) for c in contacts])
    return SupportPolygon.of_points(points), float(points[:, 2].mean())


def zero_moment_point(robot, height, q, v, dv):
    """Return where the floor at `height` pushes, by inverse dynamics of the free robot."""
    data = robot.model.createData()
    wrench = pin.rnea(robot.model, data, q, v, dv)[:6]  # on the base, in its axes
    T = pin.SE3(pin.XYZQUATToSE3(q[:7]))
    world = T.act(pin.Force(wrench))  # about the origin of the world
    force, moment = world.linear, world.angular - np.cross([0.0, 0.0, height], world.linear)
    return np.array([-moment[1], moment[0]]) / force[2], force[2]


def test_the_rows_are_the_zero_moment_point_of_inverse_dynamics(hrp2):
    polygon, height = polygon_of(hrp2)
    task = FloorSupportTask("support", hrp2, polygon, DT, height=height, margin=0.013)
    rng = np.random.default_rng(5)
    for _ in range(10):
        q, v = random_state(hrp2, rng)
        dv = 3.0 * rng.normal(size=hrp2.nv)
        rows = task.rows(hrp2.at(q, v), 0.0)
        point, push = zero_moment_point(hrp2, height, q, v, dv)
        room = push * (polygon.offsets - 0.013 - polygon.normals @ point)
        above = rows.A @ (v + DT * dv) - rows.lower
        np.testing.assert_allclose(above[:-1], DT * task.scale * room, rtol=1e-9, atol=1e-12)
        left = push / hrp2.mass - 0.3 * 9.81
        np.testing.assert_allclose(above[-1], DT * left, rtol=1e-9, atol=1e-12)
        assert np.isinf(rows.upper).all()


@pytest.mark.parametrize("dt", [0.001, 0.005])
def test_while_a_hand_is_torn_away_the_floor_only_has_to_push(hrp2, dt):
    """With the rows the floor pushes inside the soles; without, it would have to pull."""
    polygon, height = polygon_of(hrp2)
    contacts = ContactTask("contacts", ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting)))
    T = hrp2.at(hrp2.q_half_sitting).placement("left_palm")
    far = pin.SE3(T.rotation, T.translation + np.array([0.3, 0.2, 0.3]))
    hand = FramePoseTask("hand", "left_palm", FixedPose(far), rate=4.0)
    com = ComPolygonTask("com", polygon, margin=0.03, rate=3.0)
    posture = PostureTask("posture", hrp2, hrp2.q_half_sitting[7:])
    support = FloorSupportTask("support", hrp2, polygon, dt, height=height, margin=0.005)

    def least_room(levels):
        motion = MotionGenerator(hrp2, levels, make_solver("active_set"), dt, hrp2.q_half_sitting)
        v, room = np.zeros(hrp2.nv), np.inf
        for k in range(round(0.6 / dt)):
            step = motion.step(k * dt)
            point, push = zero_moment_point(hrp2, height, step.q_ref, v, (step.v_ref - v) / dt)
            room = min(room, polygon.margin(point) if push > 0.0 else -np.inf)
            v = step.v_ref.copy()
        return room

    assert least_room([[contacts], [support], [com], [hand], [posture]]) > 0.005 - 1e-6
    assert least_room([[contacts], [com], [hand], [posture]]) < -0.05
