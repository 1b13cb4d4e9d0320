"""Pushed objects: below the friction force they stay, above it they obey it, and nobody pulls."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.errors import InputError
from equipoise.physics import PushedObject, PushedObjectMode, RigidContactEngine, RigidOptions
from helpers import kinematics, sole_contacts

COULOMB, VISCOSITY = 6.0, 50.0


def pushing(robot, force, gap=0.0, seconds=0.05):
    """Hold the robot by gravity torque and push with the right palm along +y with `force` [N].

    The face lies `gap` [m] before the palm. Returns engine and its states.
    """
    q = robot.q_half_sitting
    kin = kinematics(robot, q)
    frame_id = robot.frame_id("right_palm")
    T_palm = kin.placement(frame_id)
    R = pin.Quaternion.FromTwoVectors(np.array([0, 0, 1.0]), np.array([0, -1.0, 0]))
    face = pin.SE3(R.toRotationMatrix(), T_palm.translation + np.array([0.0, gap, 0.0]))
    push = SurfaceContact(name="push", frame=frame_id, surface=Plane(), T_world_surface=face)
    soles = sole_contacts(robot, q)
    stack = ContactStack([*soles, push])
    engine = RigidContactEngine(
        robot,
        stack,
        q,
        1e-3,
        options=RigidOptions(joint_damping=200.0),
        pushed=[PushedObject("push", COULOMB, VISCOSITY)],
    )
    standing = engine.stand()
    along = kin.jacobian(frame_id)[1, 6:]
    states = []
    for _ in range(round(seconds / 1e-3)):
        states.append(engine.step(standing + force * along))
    return engine, states


def mode(engine):
    return next(iter(engine.sliders.values()))


def test_below_the_friction_force_it_stays(hrp2):
    engine, states = pushing(hrp2, 3.0)
    assert mode(engine).travel == 0.0
    assert mode(engine).mode is PushedObjectMode.STICK
    assert 0.0 < states[-1].lam[-1] < COULOMB


def test_above_it_the_force_obeys_the_law_of_friction(hrp2):
    """lam = coulomb + viscosity * speed of the face, at every slipping step."""
    q = hrp2.q_half_sitting
    engine, states = pushing(hrp2, 60.0, seconds=0.2)
    assert mode(engine).mode is PushedObjectMode.SLIP
    assert mode(engine).travel > 1e-4
    kin = kinematics(hrp2, states[-1].q)
    speed = kin.jacobian(hrp2.frame_id("right_palm"))[1] @ states[-1].v
    assert states[-1].lam[-1] == pytest.approx(COULOMB + VISCOSITY * speed, rel=1e-3)
    moved = kin.placement(hrp2.frame_id("right_palm")).translation
    start = kinematics(hrp2, q).placement(hrp2.frame_id("right_palm")).translation
    assert mode(engine).travel == pytest.approx(moved[1] - start[1], abs=1e-6)


def test_a_hand_that_retreats_pulls_nothing(hrp2):
    engine, states = pushing(hrp2, -20.0)
    assert mode(engine).mode is PushedObjectMode.FREE
    assert mode(engine).travel == 0.0
    assert min(s.lam[-1] for s in states[1:]) == 0.0


def test_before_the_gap_closes_there_is_no_force(hrp2):
    engine, states = pushing(hrp2, 3.0, gap=0.05)
    assert all(s.lam[-1] == 0.0 for s in states)
    assert mode(engine).mode is PushedObjectMode.FREE


def test_the_feet_do_not_count_the_slider_as_drift(hrp2):
    _, states = pushing(hrp2, 60.0, gap=0.001, seconds=0.1)
    assert max(s.violation for s in states) < 2e-4


@pytest.mark.parametrize(("coulomb", "viscosity"), [(-1.0, 1.0), (1.0, 0.0)])
def test_senseless_sliders_are_refused(coulomb, viscosity):
    with pytest.raises(InputError, match="slider"):
        PushedObject("push", coulomb, viscosity)
