"""Writes fixed bodies and loose objects into a MuJoCo specification."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.collision.scene import Body, Shape
from equipoise.errors import InputError
from equipoise.physics.mujoco.contact_pads import PadSensor, add_plate
from equipoise.physics.mujoco.conversion import quat_wxyz
from equipoise.physics.mujoco.names import in_model, of_object
from equipoise.physics.mujoco.objects import LooseObject
from equipoise.physics.mujoco.options import MujocoOptions
from equipoise.physics.mujoco.robot_model import (
    LINK_BIT,
    OBJECT_BIT,
    WORLD_BIT,
    place,
    set_inertia,
)
from equipoise.robots import Robot


def add_fixed(mujoco: ModuleType, spec: Any, body: Body) -> None:
    """Add a body that never moves."""
    for k, shape in enumerate(body.shapes):
        geom = _add_shape(mujoco, spec.worldbody, in_model("fixed", body.name, k), shape)
        place(geom, body.T_parent_body * shape.T_body_shape)
        geom.contype, geom.conaffinity = WORLD_BIT, LINK_BIT | OBJECT_BIT


def add_loose(
    mujoco: ModuleType,
    spec: Any,
    loose: LooseObject,
    robot: Robot,
    pads: dict[int, Any],
    options: MujocoOptions,
) -> None:
    """Add a free body, and what holds it."""
    if not loose.mass > 0.0:
        raise InputError(f"the loose object {loose.name!r} needs a mass", given=loose.mass)
    body = spec.worldbody.add_body(name=of_object(loose.name))
    place(body, loose.T_world_start)
    body.add_freejoint(name=of_object(loose.name))
    set_inertia(body, inertia_of(loose))
    for k, shape in enumerate(loose.body.shapes):
        geom = _add_shape(mujoco, body, in_model("object", loose.name, k), shape)
        place(geom, shape.T_body_shape)
        geom.contype, geom.conaffinity = OBJECT_BIT, WORLD_BIT | OBJECT_BIT | LINK_BIT
        geom.friction = [loose.friction, 0.0, 0.0]
        geom.priority = 1
        if loose.felt > 0.0:
            geom.solimp = [0.0, 0.95, loose.felt, 0.5, 2.0]
    for k, (frame, T_object_frame) in enumerate(loose.handles):
        frame_id = robot.frame_id(frame)
        if frame_id not in pads:
            names = (robot.model.frames[known].name for known in pads)
            raise InputError(
                f"the loose object {loose.name!r} is held by a frame that no contact acts at",
                given=frame,
                known=names,
                remedy="Add the grasp to the contacts",
            )
        pad = pads[frame_id]
        _weld(mujoco, spec, weld_name(loose.name, k), loose, frame_id, T_object_frame, options)
        if loose.grip == "rigid":
            spec.add_exclude(bodyname1=body.name, bodyname2=PadSensor(frame_id).body)
        else:
            add_plate(mujoco, pad, in_model("grip", loose.name, frame_id), np.zeros(3), options)


def inertia_of(loose: LooseObject) -> pin.Inertia:
    """Return mass and inertia of an object: its mass spread evenly over its shapes, plus loads."""
    volumes = [_volume(shape) for shape in loose.body.shapes]
    total = pin.Inertia.Zero()
    for shape, volume in zip(loose.body.shapes, volumes, strict=True):
        mass = loose.mass * volume / sum(volumes)
        total += shape.T_body_shape.act(_solid(shape, mass))
    for mass, point in loose.payloads:
        total += pin.Inertia(mass, np.array(point), np.zeros((3, 3)))
    return total


def _volume(shape: Shape) -> float:
    x, y, z = shape.size
    factor = {"box": 1.0, "cylinder": np.pi / 4.0, "sphere": np.pi / 6.0}[shape.kind]
    return float(factor * x * y * z)


def _solid(shape: Shape, mass: float) -> pin.Inertia:
    x, y, z = shape.size
    if shape.kind == "box":
        return pin.Inertia.FromBox(mass, x, y, z)
    if shape.kind == "sphere":
        return pin.Inertia.FromSphere(mass, x / 2.0)
    return pin.Inertia.FromCylinder(mass, x / 2.0, z)


def _add_shape(mujoco: ModuleType, body: Any, name: str, shape: Shape) -> Any:
    kinds = mujoco.mjtGeom
    x, y, z = shape.size
    kind, size = {
        "box": (kinds.mjGEOM_BOX, [x / 2.0, y / 2.0, z / 2.0]),
        "sphere": (kinds.mjGEOM_SPHERE, [x / 2.0, 0.0, 0.0]),
        "cylinder": (kinds.mjGEOM_CYLINDER, [x / 2.0, z / 2.0, 0.0]),
    }[shape.kind]
    return body.add_geom(name=name, type=kind, size=size, rgba=list(shape.rgba), mass=0.0)


def _weld(
    mujoco: ModuleType,
    spec: Any,
    name: str,
    loose: LooseObject,
    frame_id: int,
    T_object_frame: pin.SE3,
    options: MujocoOptions,
) -> None:
    """Weld the pad of a frame to an object."""
    weld = spec.add_equality(
        name=name,
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=of_object(loose.name),
        name2=PadSensor(frame_id).body,
    )
    relative = np.zeros(11)  # anchor in the second body, pose of the second in the first, scale
    relative[3:6] = T_object_frame.translation
    relative[6:10] = quat_wxyz(T_object_frame.rotation)
    relative[10] = 1.0
    weld.solref = [options.contact_time, 1.0]
    weld.data[: len(relative)] = relative


def weld_name(loose: str, handle: int) -> str:
    """Return the name of the weld between an object and the pad that is its k-th handle."""
    return in_model("weld", loose, handle)
