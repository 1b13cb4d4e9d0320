"""Pads: what soles and hands touch with, each on a massless body behind a force-torque sensor.

A pad has no mass, so what the sensor between it and its link reads is what the world does to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from equipoise.contacts import (
    Contact,
    ContactStack,
    GraspContact,
    MovingSurfaceContact,
    PointContact,
    SoleContact,
    SurfaceContact,
)
from equipoise.contacts.surfaces import Cylinder, Plane, Sphere
from equipoise.errors import InputError
from equipoise.kinematics import Kinematic, Kinematics
from equipoise.physics.mujoco.conversion import quat_wxyz
from equipoise.physics.mujoco.names import FLOOR, in_model
from equipoise.physics.mujoco.options import MujocoOptions
from equipoise.physics.mujoco.robot_model import (
    BALL_BIT,
    LINK_BIT,
    SURFACE_BIT,
    WORLD_BIT,
    place,
)
from equipoise.robots import Robot

SOLE_THICKNESS = 0.02  # [m]
FOOT_RADIUS = 0.005  # [m] of a foot that is a point: it rolls by that much a radian
BALL_RADIUS = 0.02  # [m] of the pad that slides on a smooth surface
PLATE = (0.05, 0.04, 0.005)  # [m] half sides of the pad that pushes or holds an object
_PRIORITY = 3
_KINDS = (SoleContact, PointContact, GraspContact, SurfaceContact, MovingSurfaceContact)


@dataclass(frozen=True)
class PadSensor:
    """Names of the site and of the two sensors behind the pad of a robot frame."""

    frame_id: int

    @property
    def body(self) -> str:
        """Name of the pad's body."""
        return in_model("pad", self.frame_id)

    @property
    def site(self) -> str:
        """Name of the site at the frame."""
        return in_model("frame", self.frame_id)

    @property
    def force(self) -> str:
        """Name of the force sensor."""
        return in_model("force", self.frame_id)

    @property
    def torque(self) -> str:
        """Name of the torque sensor."""
        return in_model("torque", self.frame_id)


def touching_frames(robot: Robot, contacts: ContactStack) -> tuple[int, ...]:
    """Return the ids of the robot's frames at which contacts act, each once."""
    found: dict[int, None] = {}
    for contact in contacts.contacts:
        for frame_id in frames_of(robot, contact):
            found.setdefault(frame_id)
    return tuple(found)


def frames_of(robot: Kinematic, contact: Contact) -> tuple[int, ...]:
    """Return the ids of the robot's frames at which a contact acts.

    Raises: `InputError` for a kind of contact that MuJoCo is not given.
    """
    if isinstance(contact, _KINDS):
        return tuple(dict.fromkeys(map(robot.frame_id, contact.frames)))
    raise InputError(
        f"the engine mujoco knows no contact of the kind of {contact.name!r}",
        given=type(contact).__name__,
        known=[kind.__name__ for kind in _KINDS],
    )


def add_pad_bodies(
    mujoco: ModuleType, spec: Any, robot: Robot, bodies: list[Any], contacts: ContactStack
) -> dict[int, Any]:
    """Add a massless body with its sensors at each touching frame; return them by frame."""
    pads = {}
    for frame_id in touching_frames(robot, contacts):
        frame = robot.model.frames[frame_id]
        sensor = PadSensor(frame_id)
        pad = bodies[frame.parentJoint].add_body(name=sensor.body)
        place(pad, frame.placement)
        pad.add_site(name=sensor.site)
        kinds = mujoco.mjtSensor
        at_site = {"objtype": mujoco.mjtObj.mjOBJ_SITE, "objname": sensor.site}
        spec.add_sensor(name=sensor.force, type=kinds.mjSENS_FORCE, **at_site)
        spec.add_sensor(name=sensor.torque, type=kinds.mjSENS_TORQUE, **at_site)
        pads[frame_id] = pad
    return pads


def add_pads(
    mujoco: ModuleType,
    spec: Any,
    contacts: ContactStack,
    pads: dict[int, Any],
    pushing: Mapping[str, str],
    start: Kinematics,
    options: MujocoOptions,
) -> None:
    """Give each contact its pad, and each smooth surface that is slid on its body.

    `pushing` names the surface contacts whose surface is the face of a loose object, with the pad
    that pushes it, plate or ball; `start` is the kinematics of the first state.
    """
    robot = start.robot
    for contact in contacts.contacts:
        if isinstance(contact, SoleContact):
            _add_sole(mujoco, pads[frames_of(robot, contact)[0]], contact, options)
        elif isinstance(contact, PointContact):
            _add_foot(mujoco, pads[frames_of(robot, contact)[0]], contact, start, options)
        elif isinstance(contact, SurfaceContact) and pushing.get(contact.name) == "ball":
            geom = _add_ball(mujoco, pads[frames_of(robot, contact)[0]], contact, start, options)
            geom.contype, geom.conaffinity = LINK_BIT, 0  # as a plate: it meets loose objects
        elif isinstance(contact, SurfaceContact) and contact.name in pushing:
            add_plate(
                mujoco,
                pads[frames_of(robot, contact)[0]],
                in_model("plate", contact.name),
                contact.offset,
                options,
            )
        elif isinstance(contact, SurfaceContact):
            _add_ball(mujoco, pads[frames_of(robot, contact)[0]], contact, start, options)
            _add_surface(mujoco, spec.worldbody, contact)


def _finish(mujoco: ModuleType, geom: Any, friction: float, options: MujocoOptions) -> None:
    geom.condim = 3
    geom.friction = [friction, 0.0, 0.0]
    geom.priority = _PRIORITY
    geom.solref = [options.contact_time, 1.0]
    geom.mass = 0.0
    geom.rgba = [0.2, 0.22, 0.25, 1.0]


def _add_sole(mujoco: ModuleType, pad: Any, contact: SoleContact, options: MujocoOptions) -> None:
    sole = contact.sole
    geom = pad.add_geom(
        name=in_model("sole", contact.name),
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[
            0.5 * (sole.x_max - sole.x_min),
            0.5 * (sole.y_max - sole.y_min),
            0.5 * SOLE_THICKNESS,
        ],
        pos=[
            0.5 * (sole.x_max + sole.x_min),
            0.5 * (sole.y_max + sole.y_min),
            0.5 * SOLE_THICKNESS,
        ],
        contype=LINK_BIT,
        conaffinity=0,
    )
    _finish(mujoco, geom, options.sole_friction, options)


def _add_foot(
    mujoco: ModuleType, pad: Any, contact: PointContact, start: Kinematics, options: MujocoOptions
) -> None:
    """Add a small ball that touches the floor in the point of the contact."""
    up = start.placement(contact.frame).rotation.T @ np.array([0.0, 0.0, FOOT_RADIUS])
    geom = pad.add_geom(
        name=in_model("foot", contact.name),
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[FOOT_RADIUS, 0.0, 0.0],
        pos=np.asarray(contact.offset) + up,
        contype=LINK_BIT,
        conaffinity=0,
    )
    _finish(mujoco, geom, options.sole_friction, options)


def add_plate(
    mujoco: ModuleType, pad: Any, name: str, offset: Iterable[float], options: MujocoOptions
) -> None:
    """Add a flat plate whose outer face holds the point `offset` and faces along z of the palm."""
    x, y, z = (float(value) for value in offset)
    geom = pad.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=list(PLATE),
        pos=[x, y, z - PLATE[2]],
        contype=LINK_BIT,
        conaffinity=0,
    )
    _finish(mujoco, geom, options.hand_friction, options)


def _add_ball(
    mujoco: ModuleType,
    pad: Any,
    contact: SurfaceContact,
    start: Kinematics,
    options: MujocoOptions,
) -> Any:
    R = start.placement(contact.frame).rotation
    outward = -R.T @ contact.normal(start)
    geom = pad.add_geom(
        name=in_model("ball", contact.name),
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[BALL_RADIUS, 0.0, 0.0],
        pos=np.asarray(contact.offset) - BALL_RADIUS * outward,
        contype=BALL_BIT,
        conaffinity=SURFACE_BIT,
    )
    _finish(mujoco, geom, options.hand_friction, options)
    return geom


def _add_surface(mujoco: ModuleType, world: Any, contact: SurfaceContact) -> None:
    surface, kinds = contact.surface, mujoco.mjtGeom
    if isinstance(surface, Plane):
        kind, size = kinds.mjGEOM_PLANE, [0.5, 0.5, 0.05]
    elif isinstance(surface, Sphere):
        kind, size = kinds.mjGEOM_SPHERE, [surface.radius, 0.0, 0.0]
    elif isinstance(surface, Cylinder):
        kind, size = kinds.mjGEOM_CYLINDER, [surface.radius, 1.0, 0.0]
    else:
        raise InputError(
            f"the engine mujoco has no shape for the surface of contact {contact.name!r}",
            given=type(surface).__name__,
            known=("Plane", "Sphere", "Cylinder"),
        )
    world.add_geom(
        name=in_model("surface", contact.name),
        type=kind,
        size=size,
        pos=contact.T_world_surface.translation,
        quat=quat_wxyz(contact.T_world_surface.rotation),
        contype=SURFACE_BIT,
        conaffinity=BALL_BIT,
        rgba=[0.6, 0.65, 0.7, 0.25],
    )


def floor_height(contacts: ContactStack) -> float | None:
    """Return the height [m] of the floor under soles and feet, None if nothing stands.

    Raises: `InputError` if they do not stand on one level floor.
    """
    anchors = [c.T_world_anchor for c in contacts.contacts if isinstance(c, SoleContact)]
    points = [c.p_world for c in contacts.contacts if isinstance(c, PointContact) and c.supporting]
    heights = [float(T.translation[2]) for T in anchors] + [float(p[2]) for p in points]
    if not heights:
        return None
    level = max((float(np.abs(T.rotation[:2, 2]).max()) for T in anchors), default=0.0)
    if max(heights) - min(heights) > 1e-4 or level > 1e-4:
        raise InputError(
            "the engine mujoco wants all soles and feet on one level floor",
            given=[round(h, 4) for h in heights],
        )
    return float(np.mean(heights))


def add_floor(mujoco: ModuleType, world: Any, height: float, options: MujocoOptions) -> None:
    """Add the floor plane at `height` [m]."""
    world.add_geom(
        name=FLOOR,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[3.0, 3.0, 0.1],
        pos=[0.0, 0.0, height],
        friction=[options.sole_friction, 0.0, 0.0],
        contype=WORLD_BIT,
        conaffinity=LINK_BIT | 2,
        rgba=[0.86, 0.87, 0.88, 1.0],
    )
