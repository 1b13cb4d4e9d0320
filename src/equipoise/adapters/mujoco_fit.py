"""Is the robot in a MuJoCo model ours? Joint for joint, at a posture of no symmetry."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.kinematics.followers import axes_of
from equipoise.physics.mujoco.library import load_mujoco
from equipoise.robots import Robot
from equipoise.spatial import Array

NEAR, TURNED = 1e-4, 1e-3  # [m], [rad] two descriptions are rounded differently
SLIDES = 2  # mjtJoint.mjJNT_SLIDE


def fit_of(robot: Robot, model: Any, joints: Sequence[int], base: int) -> pin.SE3:
    """Return where our world lies in MuJoCo's: the identity for a free base.

    `joints` are MuJoCo's numbers of all of ours, as `all_joints` has them; `base` that of the free
    joint, or -1.
    Raises: `InputError` naming the joint that lies elsewhere.
    """
    theirs, points, axes = _theirs(robot, model, joints, base)
    ours, our_points = _ours(robot)
    T = pin.SE3.Identity() if base >= 0 else _best(ours, our_points, theirs, points, axes)
    for name, a, p, b, x, slides in zip(
        all_joints(robot), ours, our_points, theirs, points, axes, strict=True
    ):
        turned = float(np.linalg.norm(np.cross(T.rotation @ a, b)))
        if T.rotation @ a @ b < 0.0:
            turned = np.pi
        apart = 0.0 if slides else float(np.linalg.norm(np.cross(T.act(p) - x, b)))
        if turned > TURNED or apart > NEAR:
            raise InputError(
                f"joint {name!r} lies elsewhere in MuJoCo than in robot {robot.name}: its axis is "
                f"{1e3 * apart:.3g} mm and {turned:.3g} rad off",
                given="MuJoCo model",
                remedy="Build both from one description; the free joint belongs to the body of the "
                "robot's base, and joints must count from the same zero",
            )
    return T


def all_joints(robot: Robot) -> tuple[str, ...]:
    """Return the names of the joints after the base, with those that follow others."""
    return tuple(robot.model.names)[robot.base.first_joint :]


def _theirs(
    robot: Robot, model: Any, joints: Sequence[int], base: int
) -> tuple[Array, Array, Array]:
    """Return axes (k, 3), points on them (k, 3), and which slide, at the posture of the test."""
    mujoco = load_mujoco()
    data = mujoco.MjData(model)
    numbers = list(joints)
    posture = dict(zip(robot.joint_names, _posture(robot), strict=True))
    for name, (leader, ratio, offset) in robot.followers.items():
        posture[name] = ratio * posture[leader] + offset
    places = [model.jnt_qposadr[j] for j in numbers]
    data.qpos[places] = [posture[name] for name in all_joints(robot)]
    if base >= 0:
        at = model.jnt_qposadr[base]
        data.qpos[at : at + 7] = 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0
    mujoco.mj_kinematics(model, data)
    return data.xaxis[numbers], data.xanchor[numbers], model.jnt_type[numbers] == SLIDES


def _ours(robot: Robot) -> tuple[Array, Array]:
    """Return axes (k, 3) and origins (k, 3) of our joints at the posture of the test."""
    model, own = robot.model, axes_of(robot.model)
    kin = robot.at(np.concatenate((pin.neutral(model)[: robot.nq_base], _posture(robot))))
    axes, points = [], []
    for joint in range(robot.base.first_joint, model.njoints):
        axis = own[joint, 3:] if own[joint, 3:].any() else own[joint, :3]
        T = kin.joint_placement(joint)
        axes.append(T.rotation @ axis)
        points.append(T.translation)
    return np.array(axes), np.array(points)


def _posture(robot: Robot) -> Array:
    """Return joint angles (na,) between their limits, each elsewhere."""
    low, high = np.maximum(robot.q_min, -1.0), np.minimum(robot.q_max, 1.0)
    return low + (high - low) * np.linspace(0.2, 0.7, robot.na)


def _best(ours: Array, our_points: Array, theirs: Array, points: Array, slides: Array) -> pin.SE3:
    """Return the pose that carries our axes to theirs in the sense of least squares."""
    U, _, Vt = np.linalg.svd(theirs.T @ ours)
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    across = np.eye(3) - np.einsum("ki,kj->kij", theirs, theirs)
    across[slides] = 0.0
    apart = np.einsum("kij,kj->ki", across, points - our_points @ R.T)
    return pin.SE3(R, np.linalg.lstsq(across.reshape(-1, 3), apart.ravel(), rcond=None)[0])
