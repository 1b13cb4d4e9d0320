"""The only place that knows how MuJoCo writes states and forces.

Ours (Pinocchio's free-flyer): quaternion xyzw, base linear velocity and force in base axes.
MuJoCo's free joint: quaternion wxyz, base linear velocity and force in world axes; angular ones
in body axes for both.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.spatial import Array

XYZW_FROM_WXYZ = np.array([1, 2, 3, 0])
WXYZ_FROM_XYZW = np.array([3, 0, 1, 2])


class StateConversion:
    """Converts for one model: `qpos_joints`, `dof_joints` (na,) are MuJoCo's places of our joints.

    The robot's free joint stands first in MuJoCo's arrays.
    """

    def __init__(self, qpos_joints: Array, dof_joints: Array) -> None:
        self.qpos_joints = np.asarray(qpos_joints, dtype=int)
        self.dof_joints = np.asarray(dof_joints, dtype=int)

    def q(self, qpos: Array) -> Array:
        """Return our configuration (nq,) from MuJoCo's positions."""
        q = np.empty(7 + len(self.qpos_joints))
        q[:3] = qpos[:3]
        wxyz = qpos[3:7]
        q[3:7] = wxyz[XYZW_FROM_WXYZ] / np.linalg.norm(wxyz)
        q[7:] = qpos[self.qpos_joints]
        return q

    def v(self, q: Array, qvel: Array) -> Array:
        """Return our velocity (nv,) from MuJoCo's, at our configuration `q` (nq,)."""
        v = np.empty(6 + len(self.dof_joints))
        v[:3] = base_rotation(q).T @ qvel[:3]
        v[3:6] = qvel[3:6]
        v[6:] = qvel[self.dof_joints]
        return v

    def write_q(self, q: Array, qpos: Array) -> None:
        """Write our configuration (nq,) into MuJoCo's positions."""
        qpos[:3] = q[:3]
        qpos[3:7] = q[3:7][WXYZ_FROM_XYZW]
        qpos[self.qpos_joints] = q[7:]

    def write_v(self, q: Array, v: Array, qvel: Array) -> None:
        """Write our velocity (nv,) into MuJoCo's."""
        qvel[:3] = base_rotation(q) @ v[:3]
        qvel[3:6] = v[3:6]
        qvel[self.dof_joints] = v[6:]

    def write_force(self, q: Array, force: Array, qfrc: Array) -> None:
        """Write our generalised force (nv,) into MuJoCo's (the dual of velocities)."""
        self.write_v(q, force, qfrc)


def base_rotation(q: Array) -> Array:
    """Return the rotation (3, 3) from base to world axes at `q` (nq,)."""
    x, y, z, w = q[3:7]
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quat_wxyz(R: Array) -> Array:
    """Return the unit quaternion (4,), w first, of a rotation (3, 3)."""
    return pin.Quaternion(np.asarray(R)).coeffs()[WXYZ_FROM_XYZW]


def placement(position: Array, wxyz: Array) -> pin.SE3:
    """Return the placement of a MuJoCo position (3,) and quaternion (4,), w first."""
    unit = wxyz / np.linalg.norm(wxyz)
    return pin.XYZQUATToSE3(np.concatenate((position, unit[XYZW_FROM_WXYZ])))
