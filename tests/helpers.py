"""States, kinematics and contacts that many tests build."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack, GraspContact, SoleContact
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.robots import Robot

HUMANOIDS = ("g1", "hrp2", "romeo", "talos")  # the named robots that scenarios are told for


def kinematics(robot: Robot, q: np.ndarray, v: np.ndarray | None = None) -> Kinematics:
    """Return the kinematics of a state, from an evaluator of its own."""
    return KinematicsEvaluator(robot).at(q, np.zeros(robot.nv) if v is None else v)


def random_state(robot: Robot, rng: np.random.Generator, spread: float = 0.2):
    """Return a configuration near half-sitting and a velocity."""
    step = rng.normal(size=robot.nv) * spread
    return pin.integrate(robot.model, robot.q_half_sitting, step), rng.normal(size=robot.nv) * 0.5


def sole_contacts(robot: Robot, q: np.ndarray) -> list[SoleContact]:
    """Return the robot's soles as contacts anchored where they are at `q`."""
    kin = kinematics(robot, q)
    return [SoleContact.standing(sole, kin) for sole in robot.soles]


def palm_grasp(robot: Robot, q: np.ndarray, regulated: tuple[str, ...] = ("fz",)) -> GraspContact:
    """Return a grasp between the palms as they are at `q`."""
    palms = (palm.frame for palm in robot.palms)
    return GraspContact.holding("grasp", kinematics(robot, q), *palms, regulated=regulated)


def full_stack(robot: Robot, q: np.ndarray) -> ContactStack:
    """Return both soles and the palm grasp, anchored at `q`."""
    return ContactStack([*sole_contacts(robot, q), palm_grasp(robot, q)])


def with_rotors(robot: Robot, inertia: float) -> Robot:
    """Return the robot as an engine knows it: with rotors [kg m^2] behind its gears."""
    model = robot.model.copy()
    armature = np.array(model.armature)
    armature[robot.nv_base :] += inertia
    model.armature = armature
    return replace(robot, model=model)
