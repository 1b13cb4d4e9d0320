"""The only place that knows how MuJoCo writes states and forces.

Ours (Pinocchio's free-flyer): quaternion xyzw, base linear velocity and force in base axes.
MuJoCo's free joint: quaternion wxyz, base linear velocity and force in world axes; angular ones
in body axes for both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.scratch import scratch
from equipoise.spatial import Array
from equipoise.spatial.kernels import turned, turned_back

XYZW_FROM_WXYZ = np.array([1, 2, 3, 0])
WXYZ_FROM_XYZW = np.array([3, 0, 1, 2])


class FollowerPlace(NamedTuple):
    """Where MuJoCo has a joint that follows number `leader` of ours, and by what law."""

    qpos: int
    dof: int
    leader: int
    ratio: float
    offset: float


class StateConversion:
    """Converts for one model: `qpos_joints`, `dof_joints` (na,) are MuJoCo's places of our joints.

    A floating robot's free joint stands first in MuJoCo's arrays; a robot whose base is fixed has
    none, and no entries of a base in `q` and `v`.
    """

    def __init__(
        self,
        qpos_joints: Array | Sequence[int],
        dof_joints: Array | Sequence[int],
        *,
        floating: bool = True,
    ) -> None:
        self.nq_base, self.nv_base = (7, 6) if floating else (0, 0)
        self.qpos_joints = np.array(qpos_joints, dtype=np.int64)
        self.dof_joints = np.array(dof_joints, dtype=np.int64)
        self._followers: tuple[FollowerPlace, ...] = ()

    def with_followers(self, followers: Sequence[FollowerPlace]) -> StateConversion:
        """Let joints without a coordinate of ours be placed by their leaders; return this."""
        self._followers = tuple(followers)
        return self

    def place_followers(self, qpos: Array, qvel: Array) -> None:
        """Put the joints that follow others where these are, in MuJoCo's positions and speeds."""
        for one in self._followers:
            leader_q, leader_v = self.qpos_joints[one.leader], self.dof_joints[one.leader]
            qpos[one.qpos] = one.ratio * qpos[leader_q] + one.offset
            qvel[one.dof] = one.ratio * qvel[leader_v]

    def state(self, qpos: Array, qvel: Array) -> tuple[Array, Array]:
        """Return our configuration (nq,) and velocity (nv,) from MuJoCo's."""
        na = len(self.qpos_joints)
        q, v = np.empty(self.nq_base + na), np.empty(self.nv_base + na)
        read_state(qpos, qvel, self.qpos_joints, self.dof_joints, q, v)
        return q, v

    def write_q(self, q: Array, qpos: Array) -> None:
        """Write our configuration (nq,) into MuJoCo's positions."""
        if self.nq_base:
            qpos[:3] = q[:3]
            qpos[3:7] = q[3:7][WXYZ_FROM_XYZW]
        qpos[self.qpos_joints] = q[self.nq_base :]

    def write_v(self, q: Array, v: Array, qvel: Array) -> None:
        """Write our velocity (nv,), or its dual, a force, into MuJoCo's at `q` (nq,)."""
        write_motion(np.asarray(q, dtype=float), v, self.dof_joints, qvel)


@entrance
def read_state(
    qpos: np.ndarray,
    qvel: np.ndarray,
    qpos_joints: np.ndarray,
    dof_joints: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
) -> None:
    """Write our q [nq], with a unit quaternion if the base floats, and v [nv] from MuJoCo's."""
    na = qpos_joints.shape[0]
    first_q, first_v = q.shape[0] - na, v.shape[0] - na
    if first_v > 0:
        w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
        length = math.sqrt(w * w + x * x + y * y + z * z)
        for i in range(3):
            q[i] = qpos[i]
            q[3 + i] = qpos[4 + i] / length
            v[3 + i] = qvel[3 + i]
        q[6] = w / length
        R = scratch(9)
        base_axes(q, R)
        v[0], v[1], v[2] = turned_back(R, qvel[0], qvel[1], qvel[2])
    for i in range(na):
        q[first_q + i] = qpos[qpos_joints[i]]
        v[first_v + i] = qvel[dof_joints[i]]


@entrance
def write_motion(
    q: np.ndarray, motion: np.ndarray, dof_joints: np.ndarray, theirs: np.ndarray
) -> None:
    """Write a velocity or a generalised force [nv] at our q [nq] into MuJoCo's array of it."""
    first = motion.shape[0] - dof_joints.shape[0]
    if first > 0:
        R = scratch(9)
        base_axes(q, R)
        theirs[0], theirs[1], theirs[2] = turned(R, motion[0], motion[1], motion[2])
        for i in range(3):
            theirs[3 + i] = motion[3 + i]
    for i in range(dof_joints.shape[0]):
        theirs[dof_joints[i]] = motion[first + i]


@compiled
def base_axes(q: np.ndarray, R: np.ndarray) -> None:
    """Write the rotation [9] from base to world axes at q [nq], column by column."""
    x, y, z, w = q[3], q[4], q[5], q[6]
    R[0], R[3], R[6] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    R[1], R[4], R[7] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    R[2], R[5], R[8] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


def quat_wxyz(R: Array) -> Array:
    """Return the unit quaternion (4,), w first, of a rotation (3, 3)."""
    return pin.Quaternion(np.asarray(R)).coeffs()[WXYZ_FROM_XYZW]


def placement(position: Array, wxyz: Array) -> pin.SE3:
    """Return the placement of a MuJoCo position (3,) and quaternion (4,), w first."""
    unit = wxyz / np.linalg.norm(wxyz)
    return pin.XYZQUATToSE3(np.concatenate((position, unit[XYZW_FROM_WXYZ])))
