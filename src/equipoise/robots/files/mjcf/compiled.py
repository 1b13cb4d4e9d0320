"""MuJoCo's own model of an MJCF, and names for what the file leaves without one."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.errors import RobotFileError, one_line
from equipoise.robots.files.mjcf.text import MjcfText
from equipoise.robots.files.source import ExtraMissingError

FREE, BALL, SLIDE, HINGE = range(4)  # mjtJoint
MOST_BODIES = 500
_FINITE = (
    *("body_mass", "body_inertia", "body_pos", "body_quat", "body_ipos", "body_iquat", "qpos0"),
    *("jnt_pos", "jnt_axis", "jnt_range", "dof_armature", "dof_damping", "dof_frictionloss"),
    *("site_pos", "site_quat", "geom_pos", "geom_quat", "geom_size", "key_qpos"),
)


def library() -> Any:
    """Return MuJoCo. Raises: ExtraMissingError if it is not installed."""
    try:
        return importlib.import_module("mujoco")
    except ImportError:
        raise ExtraMissingError(
            "An MJCF is read with MuJoCo, which is not installed",
            remedy="pip install 'equipoise[mujoco]', or give a URDF",
        ) from None


def compile_mjcf(text: MjcfText, path: Path) -> Any:
    """Return MuJoCo's model of a text that names no files.

    Raises: RobotFileError with what MuJoCo says, or for numbers that are not finite.
    """
    mujoco = library()
    try:
        model = mujoco.MjModel.from_xml_string(text.xml, assets=dict(text.meshes))
    except (ValueError, RuntimeError, TypeError, mujoco.FatalError) as error:
        raise RobotFileError(
            f"MuJoCo cannot read {path}: {one_line(error)}", remedy="Correct the file"
        ) from error
    if model.nbody > MOST_BODIES:
        raise RobotFileError(f"{path} has {model.nbody} bodies, at most {MOST_BODIES} are allowed")
    wrong = [name for name in _FINITE if not np.isfinite(getattr(model, name)).all()]
    if wrong:
        raise RobotFileError(f"{path} holds numbers that are not finite", given=", ".join(wrong))
    return model


def pose_of(pos: np.ndarray, quat_wxyz: np.ndarray) -> pin.SE3:
    """Return a placement of MuJoCo's: position (3,) and quaternion (4,), w first."""
    w, x, y, z = quat_wxyz / np.linalg.norm(quat_wxyz)
    return pin.SE3(pin.Quaternion(w, x, y, z).toRotationMatrix(), np.array(pos, dtype=float))


def body_name(model: Any, body: int) -> str:
    """Return the name of a body, or one by its number."""
    return str(model.body(body).name) or f"body_{body}"


def joint_name(model: Any, joint: int) -> str:
    """Return the name of a joint, or one by its body."""
    own = str(model.joint(joint).name)
    if own:
        return own
    body = int(model.jnt_bodyid[joint])
    number = joint - int(model.body_jntadr[body])
    return f"{body_name(model, body)}_joint" + (f"_{number}" if number else "")


def joints_of(model: Any, body: int) -> list[int]:
    """Return the joints of a body, in the order in which they act."""
    first = int(model.body_jntadr[body])
    return list(range(first, first + int(model.body_jntnum[body]))) if first >= 0 else []
