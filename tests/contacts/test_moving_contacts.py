"""A palm that presses on a surface while it slides over it, the surface at rest or moving."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack, MovingSurfaceContact, StraightMotion, SurfaceContact
from equipoise.contacts.surfaces import Cylinder, Plane, Sphere
from equipoise.control import (
    ControlGains,
    Measurement,
    PassivityController,
    Reference,
    SignFunction,
    advise_gains,
)
from equipoise.hqp import make_solver
from equipoise.kinematics import KinematicsEvaluator
from equipoise.motion import MotionGenerator
from equipoise.physics import RigidContactEngine
from equipoise.tasks import ContactTask, PostureTask
from helpers import kinematics, sole_contacts

DT = 1e-3


def touching(hrp2, surface, normal_world) -> dict:
    """Return frame and placement of a surface that touches the left palm with that normal."""
    frame_id = hrp2.frame_id(hrp2.palms[0].frame)
    p_world = kinematics(hrp2, hrp2.q_half_sitting).placement(frame_id).translation
    foot = surface.project(np.array([0.05, 0.04, 0.06]))
    R = pin.Quaternion.FromTwoVectors(surface.normal(foot), np.array(normal_world)).matrix()
    return {
        "frame": frame_id,
        "surface": surface,
        "T_world_surface": pin.SE3(R, p_world - R @ foot),
    }


def contact_of(hrp2, kind: str):
    """Return a regulated contact of the left palm with the face of an object in front of it."""
    surface = {"sphere": Sphere(0.2), "cylinder": Cylinder(0.15), "moving plane": Plane()}[kind]
    place = touching(hrp2, surface, (-1.0, 0.0, 0.0))
    if kind != "moving plane":
        return SurfaceContact(name="palm", regulated=("fn",), **place)
    motion = StraightMotion(
        place.pop("T_world_surface"), (1.0, 0.0, 0.0), lambda t: (0.05 * t * t, 0.1 * t, 0.1)
    )
    return MovingSurfaceContact(name="palm", regulated=("fn",), motion=motion, **place)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sphere", "cylinder", "moving plane"])
def test_a_force_is_tracked_on_the_way(hrp2, kind):
    """Distance below 0.1 mm and force within 1 % RMS while the palm travels centimetres."""
    contact = contact_of(hrp2, kind)
    stack = ContactStack([*sole_contacts(hrp2, hrp2.q_half_sitting), contact])
    goal = hrp2.q_half_sitting[7:].copy()
    goal[hrp2.joint_index("LARM_JOINT0")] -= 0.4
    goal[hrp2.joint_index("LARM_JOINT2")] += 0.5
    levels = [[ContactTask("contacts", stack)], [PostureTask("posture", hrp2, goal, rate=1.0)]]
    q_start = hrp2.q_half_sitting
    motion = MotionGenerator(hrp2, levels, make_solver("active_set"), DT, q_start)
    K_d = advise_gains(hrp2, stack, q_start, DT, alpha=20.0).K_d
    gains = ControlGains(
        K_d=K_d,
        k_ip=20.0,
        k_iF=20.0,
        eta=100.0,
        sgn_p=SignFunction("saturation", 0.1),
        sgn_F=SignFunction("saturation", 0.2),
    )
    controller = PassivityController(hrp2, stack, gains, DT)
    engine = RigidContactEngine(hrp2, stack, q_start, DT)
    row, forces, distances = stack.rows["palm"].start, [], []
    state, start = engine.state, contact.position(kinematics(hrp2, q_start))
    for k in range(700):
        step = motion.step(k * DT)
        target = Reference(step.q_ref, step.v_ref, np.array([15.0]))
        command = controller.step(k * DT, Measurement(state.q, state.v, state.lam), target)
        state = engine.step(command.tau)
        kin = KinematicsEvaluator(hrp2).at(state.q, state.v, state.t)
        forces.append(state.lam[row])
        distances.append(contact.residual(kin)[0])
    assert np.linalg.norm(contact.position(kin) - start) > 0.02
    assert np.abs(distances).max() < 1e-4
    assert np.sqrt(np.mean((np.array(forces[300:]) - 15.0) ** 2)) < 0.01 * 15.0
    if kind == "moving plane":
        assert contact.rate(kin)[0] < -0.05


def test_contacts_that_contradict_each_other_are_named(hrp2):
    """One palm between two walls that approach each other, and a sole lifted off its floor."""
    place = touching(hrp2, Plane(), (-1.0, 0.0, 0.0))
    frame_id, T = place["frame"], place["T_world_surface"]
    away = StraightMotion(T, (1.0, 0.0, 0.0), lambda t: (0.1 * t, 0.1, 0.0))
    wall = SurfaceContact(name="wall", **place)
    same = SurfaceContact(name="same wall again", **place)
    leaving = MovingSurfaceContact(
        name="leaving wall", frame=frame_id, surface=Plane(), motion=away
    )
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    soles = sole_contacts(hrp2, hrp2.q_half_sitting)
    assert ContactStack([*soles, wall, same]).contradictions(kin) == ()
    assert ContactStack([*soles, wall, leaving]).contradictions(kin) == ("leaving wall",)
    assert ContactStack([*soles, leaving, wall]).contradictions(kin) == ("wall",)
    far = SurfaceContact(
        name="far wall", frame=frame_id, surface=Plane(),
        T_world_surface=pin.SE3(T.rotation, T.translation + np.array([0.1, 0.0, 0.0])),
    )  # fmt: skip
    assert ContactStack([*soles, wall, far]).contradictions(kin) == ("far wall",)
