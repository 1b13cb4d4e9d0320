"""Contacts on surfaces, at rest and moving, and point contacts: rows, rates, drifts, forces."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from contacts_surface_kinds import KINDS
from equipoise.contacts import (
    ContactStack,
    MotionSample,
    MovingSurfaceContact,
    PointContact,
    StraightMotion,
    SurfaceContact,
    SurfaceMotion,
)
from equipoise.contacts.surfaces import Ellipsoid, Plane, Sphere
from equipoise.errors import InputError, ShapeError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics import RigidContactEngine, RigidOptions
from equipoise.spatial import pose
from helpers import kinematics, random_state, sole_contacts

STEP = 1e-6
OFFSET = (0.03, -0.02, 0.05)


class Tumbling(SurfaceMotion):
    """A surface that flies on a parabola and turns faster and faster about a fixed axis."""

    def __init__(self, T_world_start: pin.SE3) -> None:
        self.start = T_world_start
        self.axis = np.array([0.6, 0.0, 0.8])
        self.velocity = np.array([0.1, -0.2, 0.15])
        self.acceleration = np.array([0.3, 0.1, -0.4])

    def at(self, t: float) -> MotionSample:
        turned = pin.exp3(self.axis * (0.7 * t + 0.6 * t * t))
        place = self.start.translation + self.velocity * t + 0.5 * self.acceleration * t * t
        return MotionSample(
            pin.SE3(turned @ self.start.rotation, place),
            np.concatenate((self.velocity + self.acceleration * t, self.axis * (0.7 + 1.2 * t))),
            np.concatenate((self.acceleration, self.axis * 1.2)),
        )


def place_under(robot, q, surface) -> pin.SE3:
    """Return a placement at which the palm's offset point lies near (not on) the surface."""
    kin = kinematics(robot, q)
    T_world_palm = kin.placement(robot.frame_id(robot.palms[0].frame))
    p_world = T_world_palm.translation + T_world_palm.rotation @ np.array(OFFSET)
    foot = surface.project(np.array([0.07, 0.12, 0.09]))
    near = foot + 1e-9 * surface.normal(foot)
    R = pin.rpy.rpyToMatrix(0.3, -0.5, 1.1)
    return pin.SE3(R, p_world - R @ near)


def make(robot, q, kind: str, *, moving: bool):
    """Return a contact of the left palm with a surface of that kind."""
    surface = KINDS[kind]
    T = place_under(robot, q, surface)
    common = {
        "name": kind,
        "frame": robot.frame_id(robot.palms[0].frame),
        "surface": surface,
        "offset": OFFSET,
    }
    if moving:
        return MovingSurfaceContact(motion=Tumbling(T), **common)
    return SurfaceContact(T_world_surface=T, **common)


def point(robot, q) -> PointContact:
    kin = kinematics(robot, q)
    frame_id = robot.frame_id(robot.palms[0].frame)
    p_world = kin.placement(frame_id).act(np.array(OFFSET))
    return PointContact(name="tip", frame=frame_id, offset=OFFSET, p_world=p_world)


def ahead(robot, q, v, dt):
    """Return the kinematics after flowing with `v` for `dt`."""
    return KinematicsEvaluator(robot).at(pin.integrate(robot.model, q, v * dt), v, dt)


CASES = [(kind, moving) for kind in KINDS for moving in (False, True)] + [("point", False)]


@pytest.fixture(params=CASES, ids=lambda c: f"{'moving ' if c[1] else ''}{c[0]}")
def case(request, hrp2, rng):
    q, v = random_state(hrp2, rng)
    kind, moving = request.param
    return point(hrp2, q) if kind == "point" else make(hrp2, q, kind, moving=moving), q, v


def test_rows_less_rate_are_the_rate_of_the_residual(hrp2, case):
    contact, q, v = case
    change = contact.residual(ahead(hrp2, q, v, STEP)) - contact.residual(ahead(hrp2, q, v, -STEP))
    kin = kinematics(hrp2, q)
    assert np.abs(contact.jacobian(kin) @ v).max() > 1e-3
    assert np.allclose(
        contact.jacobian(kin) @ v - contact.rate(kin), change / (2 * STEP), atol=1e-7
    )


def test_drift_is_the_rate_of_rows_less_rate(hrp2, case):
    """The Hessian, the normalisation and the surface's own motion are all in it."""
    contact, q, v = case

    def speed(dt):
        kin = ahead(hrp2, q, v, dt)
        return contact.jacobian(kin) @ v - contact.rate(kin)

    expected = (speed(STEP) - speed(-STEP)) / (2 * STEP)
    assert np.allclose(contact.drift(kinematics(hrp2, q, v)), expected, atol=1e-6)


@pytest.mark.parametrize("kind", ["sphere", "ellipsoid"])
def test_the_drift_of_a_curved_surface_needs_its_hessian(hrp2, rng, kind):
    q, v = random_state(hrp2, rng)
    contact = make(hrp2, q, kind, moving=False)
    kin = kinematics(hrp2, q, v)
    flat = SurfaceContact(
        name="tangent plane",
        frame=contact.frame,
        offset=OFFSET,
        surface=Plane(),
        T_world_surface=pin.SE3(
            pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), contact.normal(kin)).matrix(),
            contact.position(kin),
        ),
    )
    assert np.allclose(flat.jacobian(kin), contact.jacobian(kin), atol=1e-9)
    assert abs(flat.drift(kin)[0] - contact.drift(kin)[0]) > 0.05


def test_the_multiplier_is_the_normal_force_for_any_phi(hrp2, rng):
    """The same ball as a distance and as an ellipsoid with a steeper phi: the same row."""
    q, v = random_state(hrp2, rng)
    ball = make(hrp2, q, "sphere", moving=False)
    steep = SurfaceContact(
        name="steep",
        frame=ball.frame,
        offset=OFFSET,
        surface=Ellipsoid((0.2, 0.2, 0.2)),
        T_world_surface=ball.T_world_surface,
    )
    kin = kinematics(hrp2, q, v)
    row = ball.jacobian(kin)
    assert np.allclose(row, steep.jacobian(kin), atol=1e-12)
    assert np.allclose(ball.drift(kin), steep.drift(kin), atol=1e-6)
    force = 10.0 * ball.normal(kin)
    J = kin.jacobian(ball.frame)
    lever = ball.position(kin) - kin.placement(ball.frame).translation
    assert np.allclose(10.0 * row[0], J[:3].T @ force + J[3:].T @ np.cross(lever, force))


def press(hrp2, contact, seconds=0.3, dt=1e-3):
    """Run soles and `contact` under gravity compensation of nobody; return engine and states."""
    q = hrp2.q_half_sitting
    stack = ContactStack([*sole_contacts(hrp2, q), contact])
    engine = RigidContactEngine(hrp2, stack, q, dt, options=RigidOptions(joint_damping=30.0))
    drifts = [engine.step(np.zeros(hrp2.na)).violation for _ in range(round(seconds / dt))]
    return engine, stack, max(drifts)


@pytest.mark.parametrize("moving", [False, True])
def test_a_palm_slides_over_a_ball_and_stays_on_it(hrp2, moving):
    """With the drift term it stays within a micrometre or so; the body really moves meanwhile."""
    frame_id = hrp2.frame_id(hrp2.palms[0].frame)
    T = kinematics(hrp2, hrp2.q_half_sitting).placement(frame_id)
    centre = pose(T.translation - np.array([0.0, 0.06, 0.08]))
    common = {"name": "ball", "frame": frame_id, "surface": Sphere(0.1)}
    if moving:
        motion = StraightMotion(centre, (0.0, 0.6, 0.8), lambda t: (0.1 * t * t, 0.2 * t, 0.2))
        contact = MovingSurfaceContact(motion=motion, **common)
    else:
        contact = SurfaceContact(T_world_surface=centre, **common)
    engine, stack, _ = press(hrp2, contact)
    state = engine.state
    kin = KinematicsEvaluator(hrp2).at(state.q, state.v, state.t)
    moved = kin.placement(frame_id).translation - T.translation
    assert np.linalg.norm(moved) > 0.01
    assert abs(contact.residual(kin)[0]) < 2e-5
    violation = stack.jacobian(kin) @ state.v - stack.rate(kin)
    assert np.abs(violation).max() < 2e-4
    if moving:
        assert stack.rate(kin)[-1] > 0.02


def test_four_corner_points_are_the_sole(hrp2, rng):
    """24 rows of rank 12: the same motion, the same net wrench, no huge force."""
    q = hrp2.q_half_sitting
    soles = sole_contacts(hrp2, q)
    corners = [
        PointContact(
            name=f"{sole.name}/{i}",
            frame=sole.frame,
            offset=tuple(corner),
            p_world=sole.T_world_anchor.act(corner),
            supporting=True,
        )
        for sole in soles
        for i, corner in enumerate(sole.sole.corners)
    ]
    by_soles, by_corners = ContactStack(soles), ContactStack(corners)
    force = np.concatenate((np.zeros(6), rng.normal(size=hrp2.na) * 10))
    a_soles, lam_soles = RigidContactEngine(hrp2, by_soles, q, 1e-3).accelerations(force)
    a_corners, lam_corners = RigidContactEngine(hrp2, by_corners, q, 1e-3).accelerations(force)
    scale = np.abs(lam_soles).max()
    assert np.allclose(a_soles, a_corners, atol=1e-6 * np.abs(a_soles).max())
    assert np.abs(lam_corners).max() < 10.0 * scale
    for k, sole in enumerate(soles):
        forces = lam_corners[12 * k : 12 * k + 12].reshape(4, 3)
        R = sole.T_world_anchor.rotation
        levers = sole.sole.corners @ R.T
        wrench = np.concatenate(
            (R.T @ forces.sum(axis=0), R.T @ np.cross(levers, forces).sum(axis=0))
        )
        assert np.allclose(wrench, lam_soles[6 * k : 6 * k + 6], atol=1e-6 * scale)
    kin = kinematics(hrp2, q)
    stacked = by_corners.at(kin)
    assert stacked.rank == 12
    assert np.allclose(stacked.Q_phi, by_soles.at(kin).Q_phi, atol=1e-10)
    assert np.abs(stacked.J_phi_pinv).max() < 1e3


def test_a_contact_twice_halves_its_multiplier(hrp2, rng):
    q, _ = random_state(hrp2, rng, spread=0.05)
    soles = sole_contacts(hrp2, q)
    once = make(hrp2, q, "sphere", moving=False)
    twice = make(hrp2, q, "sphere", moving=False)
    object.__setattr__(twice, "name", "again")
    force = np.concatenate((np.zeros(6), rng.normal(size=hrp2.na) * 10))
    a_1, lam_1 = RigidContactEngine(hrp2, ContactStack([*soles, once]), q, 1e-3).accelerations(
        force
    )
    a_2, lam_2 = RigidContactEngine(
        hrp2, ContactStack([*soles, once, twice]), q, 1e-3
    ).accelerations(force)
    assert np.allclose(a_1, a_2, atol=1e-6 * np.abs(a_1).max())
    assert np.isclose(lam_2[-1] + lam_2[-2], lam_1[-1], atol=1e-6 * np.abs(lam_1).max())
    assert np.abs(lam_2).max() < 2.0 * np.abs(lam_1).max()


def test_bad_contacts_are_refused_by_name(hrp2):
    with pytest.raises(ShapeError, match="'tip'"):
        PointContact(name="tip", frame=3, p_world=np.zeros(2))
    with pytest.raises(InputError, match="'palm'"):
        SurfaceContact(name="palm", frame=3, surface=Plane(), offset=(0.0, np.nan, 0.0))
    with pytest.raises(InputError, match="unit vector"):
        StraightMotion(pin.SE3.Identity(), (1.0, 1.0, 0.0), lambda t: (0.0, 0.0, 0.0))
