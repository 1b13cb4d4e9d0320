"""Writes a robot into a MuJoCo specification: bodies, joints, inertias, shapes."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from equipoise.kinematics.followers import axes_of
from equipoise.physics.mujoco.conversion import quat_wxyz
from equipoise.physics.mujoco.names import BASE, in_model, of_joint
from equipoise.physics.mujoco.options import MujocoOptions
from equipoise.robots import Robot
from equipoise.spatial import Array

LEAST_MASS, LEAST_INERTIA = 1e-9, 1e-12  # [kg], [kg m^2] of what has none between two joints
STIFFEST = 2.0  # steps in which a joint comes back to its leader; MuJoCo takes no fewer
WORLD_BIT, OBJECT_BIT, LINK_BIT, SURFACE_BIT, BALL_BIT = 1, 2, 4, 8, 16


def add_robot(mujoco: ModuleType, spec: Any, robot: Robot, options: MujocoOptions) -> list[Any]:
    """Add the robot's tree; return MuJoCo's body of each Pinocchio joint, index 0 the world."""
    model, axes = robot.model, axes_of(robot.model)
    bodies: list[Any] = [spec.worldbody]
    if any(inertia.mass <= 0.0 for inertia in model.inertias[1:]):  # several joints at one body
        spec.compiler.boundmass, spec.compiler.boundinertia = LEAST_MASS, LEAST_INERTIA
    for joint in range(1, model.njoints):
        body = bodies[model.parents[joint]].add_body(name=body_name(robot, joint))
        place(body, model.jointPlacements[joint])
        set_inertia(body, model.inertias[joint])
        if joint < robot.base.first_joint:
            body.add_freejoint(name=BASE)
        else:
            _add_joint(mujoco, body, robot, joint, axes[joint], options)
        bodies.append(body)
    _couple(mujoco, spec, robot, options)
    return bodies


def body_name(robot: Robot, joint: int) -> str:
    """Return the name of the body that moves with a joint."""
    return BASE if joint < robot.base.first_joint else of_joint(robot.model.names[joint])


def _add_joint(
    mujoco: ModuleType, body: Any, robot: Robot, joint: int, axis: Array, options: MujocoOptions
) -> None:
    """Add a joint; one that follows another has no motor, losses and limits of its own."""
    turning = bool(np.abs(axis[3:]).max() > 0.5)
    added = body.add_joint(
        name=of_joint(robot.model.names[joint]),
        type=mujoco.mjtJoint.mjJNT_HINGE if turning else mujoco.mjtJoint.mjJNT_SLIDE,
        axis=axis[3:] if turning else axis[:3],
    )
    if joint not in robot.actuated:
        return
    i = robot.model.idx_vs[joint] - robot.nv_base
    added.frictionloss = _like(added.frictionloss, options.joint_friction)
    added.armature = options.armature + float(robot.model.armature[robot.model.idx_vs[joint]])
    added.damping = _like(added.damping, options.joint_damping)
    low, high = float(robot.q_min[i]), float(robot.q_max[i])
    if np.isfinite(low) and np.isfinite(high) and high - low < 1e3:
        added.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        added.range = [low, high]


def _couple(mujoco: ModuleType, spec: Any, robot: Robot, options: MujocoOptions) -> None:
    """Tie joints to the ones that they follow, as stiffly as the steps allow."""
    for name, (leader, ratio, offset) in robot.followers.items():
        tie = spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            name1=of_joint(name),
            name2=of_joint(leader),
        )
        tie.data[:2] = offset, ratio
        tie.solref = [STIFFEST * spec.option.timestep, 1.0]
        tie.solimp = [0.95, 0.99, 0.001, 0.5, 2.0]


def _like(present: Any, value: float) -> Any:
    """Return `value` in the form the library keeps it in: a number, or a polynomial's first."""
    if np.ndim(present) == 0:
        return value
    coefficients = np.zeros(len(present))
    coefficients[0] = value
    return coefficients


def place(element: Any, T: pin.SE3) -> None:
    """Put a body, geom or site at `T` in its parent."""
    element.pos = T.translation
    element.quat = quat_wxyz(T.rotation)


def set_inertia(body: Any, inertia: pin.Inertia) -> None:
    """Give a body its mass, centre of mass and principal inertia."""
    moments, axes = principal_axes(inertia)
    body.explicitinertial = True
    body.mass = inertia.mass
    body.ipos = inertia.lever
    body.iquat = quat_wxyz(axes)
    body.inertia = moments


def principal_axes(inertia: pin.Inertia) -> tuple[Array, Array]:
    """Return the principal moments (3,) [kg m^2] and axes (3, 3), a rotation."""
    moments, axes = np.linalg.eigh(inertia.inertia)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    return moments, axes


def add_link_shapes(
    mujoco: ModuleType, spec: Any, robot: Robot, bodies: list[Any], touchless: set[int]
) -> None:
    """Add the collision shapes of the links; those of `touchless` joints are only seen."""
    for k, shape in enumerate(robot.collision_model.geometryObjects):
        geom = _shape(mujoco, spec, bodies[shape.parentJoint], in_model("link", k), shape)
        if geom is None:
            continue
        place_after_mesh(geom, shape)
        touches = shape.parentJoint not in touchless
        geom.contype, geom.conaffinity = (LINK_BIT if touches else 0), 0
        geom.rgba = [0.78, 0.8, 0.83, 1.0]
        geom.mass = 0.0


def place_after_mesh(geom: Any, shape: pin.GeometryObject) -> None:
    """Put the geom where the shape is on its joint."""
    place(geom, shape.placement)


def _shape(
    mujoco: ModuleType, spec: Any, body: Any, name: str, shape: pin.GeometryObject
) -> Any | None:
    kinds = mujoco.mjtGeom
    geometry = shape.geometry
    if isinstance(geometry, coal.Box):
        size = geometry.halfSide
        return body.add_geom(name=name, type=kinds.mjGEOM_BOX, size=size)
    if isinstance(geometry, coal.Capsule):
        size = [geometry.radius, geometry.halfLength, 0.0]
        return body.add_geom(name=name, type=kinds.mjGEOM_CAPSULE, size=size)
    if isinstance(geometry, coal.Cylinder):
        size = [geometry.radius, geometry.halfLength, 0.0]
        return body.add_geom(name=name, type=kinds.mjGEOM_CYLINDER, size=size)
    if isinstance(geometry, coal.Sphere):
        return body.add_geom(name=name, type=kinds.mjGEOM_SPHERE, size=[geometry.radius, 0.0, 0.0])
    vertices = _vertices(geometry, shape)
    if vertices is None or len(vertices) < 4:
        return None
    spec.add_mesh(name=name, uservert=vertices.ravel())
    return body.add_geom(name=name, type=kinds.mjGEOM_MESH, meshname=name)


def _vertices(geometry: Any, shape: pin.GeometryObject) -> Array | None:
    """Return the vertices (k, 3) [m] of a mesh: MuJoCo takes their convex hull."""
    if isinstance(geometry, coal.BVHModelBase):
        return np.array(geometry.vertices())
    if isinstance(geometry, coal.ConvexBase):
        return np.array(geometry.points())
    return None
