"""Builds Pinocchio's model from MuJoCo's compiled one: joints, links, sites, masses, limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.errors import RobotFileError
from equipoise.robots.base import FIXED, FLOATING, Base
from equipoise.robots.files.build import ROOT_JOINT
from equipoise.robots.files.finding import WARNING, Finding
from equipoise.robots.files.mjcf.compiled import (
    BALL,
    FREE,
    HINGE,
    body_name,
    joint_name,
    joints_of,
    pose_of,
)
from equipoise.robots.files.mjcf.limits import JointLimits

AXIS = 1e-12  # off a coordinate axis, below which a joint is taken as about it


@dataclass
class Tree:
    """A model, and where MuJoCo's bodies and joints are in it.

    `carrier` is the joint that moves a body, `T_carrier_body` where the body is on it, `frame` its
    frame; `joint` the joint made of one of MuJoCo's.
    """

    model: pin.Model
    base: Base
    carrier: dict[int, int] = field(default_factory=dict)
    T_carrier_body: dict[int, pin.SE3] = field(default_factory=dict)
    frame: dict[int, int] = field(default_factory=dict)
    joint: dict[int, int] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)


def base_in_file(compiled: Any, path: Path) -> tuple[Base, int]:
    """Return the base that an MJCF describes, and the body that is free, 0 if none.

    Raises: RobotFileError for ball joints, several free bodies, or a free body below another.
    """
    kinds = np.array(compiled.jnt_type)
    if not len(kinds):
        raise RobotFileError(
            f"{path} has no joint: there is nothing to move",
            remedy="Give the file of the robot, not that of a scene without it",
        )
    for joint in np.flatnonzero(kinds == BALL):
        raise RobotFileError(
            f"{path}: joint {joint_name(compiled, int(joint))!r} is a ball joint",
            remedy="Write three hinges in its place",
        )
    free = [int(compiled.jnt_bodyid[joint]) for joint in np.flatnonzero(kinds == FREE)]
    if not free:
        return FIXED, 0
    roots = {int(compiled.body_rootid[int(body)]) for body in compiled.jnt_bodyid}
    if len(free) > 1 or len(roots) > 1:
        names = ", ".join(body_name(compiled, root) for root in sorted(roots))
        raise RobotFileError(
            f"{path} holds several bodies that move by themselves",
            given=names,
            remedy="Keep the robot alone in the file; objects belong to the scenario",
        )
    return FLOATING, free[0]


def build_tree(
    compiled: Any,
    base: Base,
    root: int,
    limits: Mapping[int, JointLimits],
    locked: Mapping[int, float],
) -> Tree:
    """Return the model with a base of a kind, whose first moving body is `root` (0: the world).

    `locked` gives by joint the coordinate at which it is fixed.
    """
    model = pin.Model()
    tree = Tree(model, base, {0: 0}, {0: pin.SE3.Identity()}, {0: 0})
    for body in range(1, compiled.nbody):
        parent = int(compiled.body_parentid[body])
        T = pose_of(compiled.body_pos[body], compiled.body_quat[body])
        T_carrier, carrier = tree.T_carrier_body[parent] * T, tree.carrier[parent]
        above = tree.frame[parent]
        if body == root:
            if base is FLOATING:
                free = pin.JointModelFreeFlyer()
                carrier = model.addJoint(0, free, pin.SE3.Identity(), ROOT_JOINT)
                above = model.addJointFrame(carrier, 0)
            T_carrier = pin.SE3.Identity()
        for joint in joints_of(compiled, body):
            if compiled.jnt_type[joint] == FREE:
                continue
            anchor = pin.SE3(np.eye(3), np.array(compiled.jnt_pos[joint]))
            reference = float(compiled.qpos0[compiled.jnt_qposadr[joint]])
            turning = compiled.jnt_type[joint] == HINGE
            axis = np.array(compiled.jnt_axis[joint])
            place = T_carrier * anchor
            if joint in locked:
                T_carrier = place * _moved(axis, turning, locked[joint] - reference)
            else:
                place = place * _moved(axis, turning, -reference)
                carrier = _add_joint(compiled, model, carrier, joint, place, limits[joint])
                above = model.addJointFrame(carrier, above)
                tree.joint[joint] = carrier
                T_carrier = pin.SE3.Identity()
            T_carrier = T_carrier * anchor.inverse()
        tree.carrier[body], tree.T_carrier_body[body] = carrier, T_carrier
        inertia = _inertia(compiled, body)
        model.appendBodyToJoint(carrier, inertia, T_carrier)
        frame = pin.Frame(
            body_name(compiled, body), carrier, above, T_carrier, pin.FrameType.BODY
        )  # fmt: skip
        tree.frame[body] = model.addFrame(frame, False)
    _add_sites(compiled, tree)
    return tree


def _add_joint(
    compiled: Any, model: pin.Model, parent: int, joint: int, place: pin.SE3, limits: JointLimits
) -> int:
    axis = np.array(compiled.jnt_axis[joint], dtype=float)
    kind = _kind(axis, turning=compiled.jnt_type[joint] == HINGE)
    bounds = [np.array([x]) for x in (limits.effort, limits.velocity, limits.lower, limits.upper)]
    added = model.addJoint(parent, kind, place, joint_name(compiled, joint), *bounds)
    at, dof = model.joints[added].idx_v, int(compiled.jnt_dofadr[joint])
    model.armature[at] = compiled.dof_armature[dof]
    model.damping[at] = np.ravel(compiled.dof_damping[dof])[0]
    model.upperDryFrictionLimit[at] = compiled.dof_frictionloss[dof]
    model.lowerDryFrictionLimit[at] = -compiled.dof_frictionloss[dof]
    return added


def _kind(axis: np.ndarray, *, turning: bool) -> Any:
    """Return Pinocchio's joint about or along an axis, the plain one where it is a coordinate's."""
    for k, name in enumerate("XYZ"):
        if np.abs(axis - np.eye(3)[k]).max() < AXIS:
            return getattr(pin, f"JointModel{'R' if turning else 'P'}{name}")()
    unaligned = pin.JointModelRevoluteUnaligned if turning else pin.JointModelPrismaticUnaligned
    return unaligned(axis / np.linalg.norm(axis))


def _moved(axis: np.ndarray, turning: bool, by: float) -> pin.SE3:
    if turning:
        return pin.SE3(pin.exp3(axis * by), np.zeros(3))
    return pin.SE3(np.eye(3), axis * by)


def _inertia(compiled: Any, body: int) -> pin.Inertia:
    """Return the inertia of a body in its own axes."""
    T = pose_of(compiled.body_ipos[body], compiled.body_iquat[body])
    about = T.rotation @ np.diag(compiled.body_inertia[body]) @ T.rotation.T
    return pin.Inertia(float(compiled.body_mass[body]), T.translation, about)


def _add_sites(compiled: Any, tree: Tree) -> None:
    """Add a frame for each site that has a name."""
    taken = {frame.name for frame in tree.model.frames}
    for site in range(compiled.nsite):
        name = given = str(compiled.site(site).name)
        if not name:
            continue
        while name in taken:
            name += "_site"
        if name != given:
            problem = f"a body or joint has its name too: its frame is called {name!r}"
            tree.findings.append(Finding(WARNING, f"site {given!r}", problem))
        taken.add(name)
        body = int(compiled.site_bodyid[site])
        T = tree.T_carrier_body[body] * pose_of(compiled.site_pos[site], compiled.site_quat[site])
        frame = pin.Frame(name, tree.carrier[body], tree.frame[body], T, pin.FrameType.OP_FRAME)
        tree.model.addFrame(frame, False)
