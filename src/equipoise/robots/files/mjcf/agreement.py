"""Compares our model of an MJCF with MuJoCo's: sizes, names, masses, inertia matrix, bias force."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.errors import RobotFileError
from equipoise.robots.base import FLOATING
from equipoise.robots.files.mjcf.compiled import FREE, joint_name, library
from equipoise.robots.files.mjcf.tree import Tree

STATES, TOLERANCE = 10, 1e-9  # relative to the largest entry
SPREAD, SPEED = 1.0, 1.0  # [rad or m] and [1/s] of the random states


def require_agreement(compiled: Any, tree: Tree, path: Path) -> None:
    """Refuse a model that is not MuJoCo's. Raises: RobotFileError with what differs."""
    problem = difference(compiled, tree)
    if problem:
        raise RobotFileError(
            f"{path}: the model built from it differs from MuJoCo's: {problem}",
            remedy="Do not use it; this is a fault of the reader, please report the file",
        )


def difference(compiled: Any, tree: Tree, states: int = STATES) -> str:
    """Return what differs between the two models, or nothing."""
    model = tree.model
    if model.nv != compiled.nv:
        return f"{model.nv} degrees of freedom, MuJoCo has {compiled.nv}"
    for theirs, ours in tree.joint.items():
        if model.names[ours] != joint_name(compiled, theirs):
            return f"joint {joint_name(compiled, theirs)!r} is called {model.names[ours]!r}"
    mass, whole = sum(inertia.mass for inertia in model.inertias), float(compiled.body_mass.sum())
    if abs(mass - whole) > TOLERANCE * max(whole, 1.0):
        return f"{mass:g} kg, MuJoCo has {whole:g} kg"
    gaps = gap_at_random(compiled, tree, np.random.default_rng(0), states)
    for what, gap in zip(("inertia matrix", "bias force"), gaps, strict=True):
        if not gap <= TOLERANCE:
            return f"the {what} is off by {gap:.2g} of its size"
    return ""


def gap_at_random(
    compiled: Any, tree: Tree, random: np.random.Generator, states: int
) -> tuple[float, float]:
    """Return by how much inertia matrix and bias force differ at most, by their largest entry.

    A free body's linear velocity is in world axes there and in its own here.
    """
    mujoco = library()
    model, theirs, ours = tree.model, mujoco.MjData(compiled), tree.model.createData()
    floats, worst = tree.base is FLOATING, [0.0, 0.0]
    order, places = _order(compiled, tree)
    for _ in range(states):
        q = pin.integrate(model, pin.neutral(model), SPREAD * random.normal(size=model.nv))
        v = SPEED * random.normal(size=model.nv)
        theirs.qpos[:], theirs.qvel[:] = compiled.qpos0, 0.0
        theirs.qpos[places], theirs.qvel[order] = q[tree.base.nq :], v[tree.base.nv :]
        B, speed = np.zeros((model.nv, model.nv)), np.zeros(model.nv)
        B[order, np.arange(tree.base.nv, model.nv)] = 1.0
        if floats:
            R = pin.Quaternion(*q[[6, 3, 4, 5]]).toRotationMatrix()
            at, dof = _free(compiled)
            theirs.qpos[at : at + 7] = q[[0, 1, 2, 6, 3, 4, 5]]
            theirs.qvel[dof : dof + 3], theirs.qvel[dof + 3 : dof + 6] = R @ v[:3], v[3:6]
            B[dof : dof + 3, :3], B[dof + 3 : dof + 6, 3:6] = R, np.eye(3)
            speed[dof : dof + 3] = R @ np.cross(v[3:6], v[:3])
        mujoco.mj_forward(compiled, theirs)
        M_theirs = _inertia_matrix(mujoco, compiled, theirs)
        upper = np.triu(pin.crba(model, ours, q))
        M = upper + np.triu(upper, 1).T
        bias = pin.nonLinearEffects(model, ours, q, v)
        wanted = B.T @ (theirs.qfrc_bias + M_theirs @ speed)
        for k, (one, other) in enumerate(((M, B.T @ M_theirs @ B), (bias, wanted))):
            size = max(float(np.abs(other).max()), 1e-6)
            worst[k] = max(worst[k], float(np.abs(one - other).max()) / size)
    return worst[0], worst[1]


def _inertia_matrix(mujoco: Any, compiled: Any, theirs: Any) -> np.ndarray:
    M = np.zeros((compiled.nv, compiled.nv))
    try:
        mujoco.mj_fullM(compiled, theirs, M)
    except TypeError:  # before version 4
        mujoco.mj_fullM(compiled, M, theirs.qM)
    return M


def _order(compiled: Any, tree: Tree) -> tuple[np.ndarray, np.ndarray]:
    """Return MuJoCo's places of our joints in velocities and in positions."""
    joints = sorted(tree.joint, key=lambda joint: tree.joint[joint])
    dofs, places = compiled.jnt_dofadr, compiled.jnt_qposadr
    return np.array(dofs)[joints], np.array(places)[joints]


def _free(compiled: Any) -> tuple[int, int]:
    joint = int(np.flatnonzero(np.array(compiled.jnt_type) == FREE)[0])
    return int(compiled.jnt_qposadr[joint]), int(compiled.jnt_dofadr[joint])
