"""What is simulated and the controller is not told: true masses, payloads, objects that slide."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin

from equipoise.errors import ScenarioError
from equipoise.physics import PushedObject
from equipoise.robots import Robot
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import frame_of, to_vector
from equipoise.simulation.build.setup import Setup, check_object
from equipoise.spatial import Array


def plant_robot(scenario: schema.Scenario, setup: Setup) -> Robot:
    """Return the robot that is simulated: nominal, with the disturbances the law is not told."""
    disturbances = scenario.disturbances
    robot = setup.robot
    if disturbances.mass_scale != 1.0:
        robot = robot.scaled(disturbances.mass_scale)
    robot = _with_scaled_links(robot, disturbances.links)
    if any(disturbances.com_shift):
        robot = _with_shifted_com(robot, to_vector(disturbances.com_shift))
    for i, payload in enumerate(disturbances.payloads):
        path = f"disturbances.payloads.{i}"
        point = np.array(payload.at)
        if payload.object is not None:
            check_object(scenario, payload.object, f"{path}.object")
            if scenario.physics.engine == "mujoco":
                continue  # there the object is a body of its own and carries it itself
            robot = _with_load_in_hands(robot, setup, payload.object, payload.mass, point)
        else:
            frame = payload.frame or ""
            frame_of(robot, frame, f"{path}.frame")
            robot = robot.with_payload(frame, payload.mass, tuple(point))
    return robot


def _with_load_in_hands(robot: Robot, setup: Setup, held: str, mass: float, point: Array) -> Robot:
    """Return the robot with a mass [kg] at a point (3,) of a massless object, in equal shares.

    Each hand then carries its share itself, and what passes between them is the squeeze.
    """
    hands = [hand for name, hand in setup.handles if name == held]
    for hand in hands:
        at = setup.handles[held, hand].actInv(point)
        robot = robot.with_payload(hand, mass / len(hands), tuple(at))
    return robot


def _with_scaled_links(robot: Robot, links: Mapping[str, schema.LinkScaleSpec]) -> Robot:
    model = robot.model.copy()
    for name, spec in links.items():
        joint = _moving(robot, name)
        inertia = model.inertias[joint]
        model.inertias[joint] = pin.Inertia(
            spec.mass * inertia.mass, inertia.lever, spec.inertia * inertia.inertia
        )
    return replace(robot, model=model) if links else robot


def _with_shifted_com(robot: Robot, shift: tuple[float, float, float]) -> Robot:
    """Return the robot whose mass lies off by `shift` [m], base axes, as it stands half-sitting."""
    model = robot.model.copy()
    kin = robot.at(robot.q_half_sitting)
    base = kin.joint_placement(1).rotation if robot.nv_base else np.eye(3)
    for joint in range(1, model.njoints):
        inertia, R = model.inertias[joint], kin.joint_placement(joint).rotation
        lever = inertia.lever + R.T @ base @ np.array(shift)
        model.inertias[joint] = pin.Inertia(inertia.mass, lever, inertia.inertia)
    return replace(robot, model=model)


def _moving(robot: Robot, name: str) -> int:
    """Return the joint that a link moves with, or that is called so itself.

    Raises: `ScenarioError` for what is fixed to a link: it would be the whole link that is scaled.
    """
    path = f"disturbances.links.{name}"
    frames = robot.model.frames
    frame = frames[robot.frame_id(frame_of(robot, name, path))]
    moved = {
        link.parentJoint: link.name
        for link in frames
        if link.type == pin.FrameType.BODY and frames[link.parentFrame].type == pin.FrameType.JOINT
    }
    if frame.type == pin.FrameType.JOINT or name == moved.get(frame.parentJoint):
        return frame.parentJoint
    link = moved[frame.parentJoint]
    raise ScenarioError(
        f"{name!r} is fixed to the link {link!r}, which carries its mass",
        path=path,
        known=sorted(moved.values()),
        remedy=f"Name {link!r}: all that is fixed to it is scaled together",
    )


def plant_objects(scenario: schema.Scenario) -> list[PushedObject]:
    """Return the objects behind the pushing contacts."""
    sliders = scenario.world.sliders
    return [
        PushedObject(name, sliders[spec.slider].coulomb, sliders[spec.slider].viscosity, spec.pad)
        for name, spec in scenario.contacts.items()
        if isinstance(spec, schema.PushContactSpec)
    ]


def one_sided_surfaces(scenario: schema.Scenario) -> list[str]:
    """Return the names of the surfaces that a hand comes to or leaves: they only push."""
    return [
        name
        for name, spec in scenario.contacts.items()
        if isinstance(spec, schema.SurfaceContactSpec) and spec.comes_or_goes
    ]
