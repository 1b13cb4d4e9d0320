"""A grasp: two frames of the robot hold one rigid massless object, six rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled.compilation import compiled
from equipoise.compiled.scratch import scratch, scratch_matrix
from equipoise.contacts.base import WRENCH_LABELS, WRENCH_UNITS, CompiledContact
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import frame_motion
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import crossed, rotation_difference, turned_back


@dataclass(frozen=True, kw_only=True)
class GraspContact(CompiledContact):
    """The pose of frame b relative to frame a stays at `T_a_b`.

    Rows and wrench are written in the axes of a, at the origin of b: `lam` is the wrench the
    object exerts on the body of b (and its opposite on the body of a). With the z axis of a
    pointing to b, `lam[2] >= 0` is a squeeze of the object.
    """

    frame_a: int
    frame_b: int
    T_a_b: pin.SE3

    @classmethod
    def holding(
        cls,
        name: str,
        kin: Kinematics,
        frame_a: str,
        frame_b: str,
        *,
        regulated: tuple[str, ...] = (),
    ) -> GraspContact:
        """Return the grasp of an object between two frames as they are at the state of `kin`.

        Raises: NameNotFoundError if the robot has no such frame, the contact no such row.
        """
        a, b = kin.robot.frame_id(frame_a), kin.robot.frame_id(frame_b)
        T_a_b = kin.placement(a).actInv(kin.placement(b))
        return cls(name=name, regulated=regulated, frame_a=a, frame_b=b, T_a_b=T_a_b)

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""
        return WRENCH_LABELS

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""
        return WRENCH_UNITS

    kernel = "grasp"

    @property
    def frames(self) -> tuple[int, int]:
        """Frames a and b."""
        return self.frame_a, self.frame_b

    @property
    def kept(self) -> Array:
        """The pose of b in a as a row (12,)."""
        return pose_row(self.T_a_b)


@compiled
def grasp_rows(
    columns: np.ndarray,
    carried_a: np.ndarray,
    carried_b: np.ndarray,
    T_a: np.ndarray,
    T_b: np.ndarray,
    held: np.ndarray,
    J: np.ndarray,
    residual: np.ndarray,
    at: int,
) -> None:
    """Write the twist of b as seen from a, and how far b is from its place `held` in a.

    Both bodies are looked at in the origin of b, so that what moves both of them drops out.
    """
    px, py, pz = T_b[9], T_b[10], T_b[11]
    for c in range(columns.shape[0]):
        sign = carried_b[c] - carried_a[c]
        if sign == 0.0:
            for i in range(6):
                J[at + i, c] = 0.0
            continue
        wx, wy, wz = sign * columns[c, 3], sign * columns[c, 4], sign * columns[c, 5]
        lx, ly, lz = crossed(wx, wy, wz, px, py, pz)
        lx, ly, lz = (
            lx + sign * columns[c, 0],
            ly + sign * columns[c, 1],
            lz + sign * columns[c, 2],
        )
        J[at, c], J[at + 1, c], J[at + 2, c] = turned_back(T_a, lx, ly, lz)
        J[at + 3, c], J[at + 4, c], J[at + 5, c] = turned_back(T_a, wx, wy, wz)
    x, y, z = turned_back(T_a, px - T_a[9], py - T_a[10], pz - T_a[11])
    residual[at], residual[at + 1], residual[at + 2] = x - held[9], y - held[10], z - held[11]
    seen = scratch(12)  # the pose of b in a
    for k in range(3):
        x, y, z = turned_back(T_a, T_b[3 * k], T_b[3 * k + 1], T_b[3 * k + 2])
        seen[3 * k], seen[3 * k + 1], seen[3 * k + 2] = x, y, z
    x, y, z = rotation_difference(seen, held)
    residual[at + 3], residual[at + 4], residual[at + 5] = x, y, z


@compiled
def grasp_drift(
    joints: np.ndarray,
    velocities: np.ndarray,
    accelerations: np.ndarray,
    a: int,
    b: int,
    T_a: np.ndarray,
    T_b: np.ndarray,
    drift: np.ndarray,
    at: int,
) -> None:
    """Write `dJ/dt v`: the relative acceleration at zero `dv/dt`, seen from the turning a.

    In axes that turn with omega, `x_seen'' = x'' - 2 omega x x_seen' - omega x (omega x x) -
    omega' x x`; the accelerations of a and b give the first and the last.
    """
    of_a, of_b = scratch_matrix(2, 6), scratch_matrix(2, 6)
    frame_motion(joints[a], velocities[a], accelerations[a], T_a, of_a)
    frame_motion(joints[b], velocities[b], accelerations[b], T_b, of_b)
    v, bias = of_b[0], of_b[1]
    for i in range(6):
        v[i] -= of_a[0, i]
        bias[i] -= of_a[1, i]
    wx, wy, wz = of_a[0, 3], of_a[0, 4], of_a[0, 5]
    rx, ry, rz = T_b[9] - T_a[9], T_b[10] - T_a[10], T_b[11] - T_a[11]
    cx, cy, cz = crossed(wx, wy, wz, rx, ry, rz)
    # velocity as seen, and once more as it is: together the two middle terms
    sx, sy, sz = 2.0 * v[0] - cx, 2.0 * v[1] - cy, 2.0 * v[2] - cz
    cx, cy, cz = crossed(wx, wy, wz, sx, sy, sz)
    ex, ey, ez = crossed(of_a[1, 3], of_a[1, 4], of_a[1, 5], rx, ry, rz)
    x, y, z = turned_back(T_a, bias[0] - ex - cx, bias[1] - ey - cy, bias[2] - ez - cz)
    drift[at], drift[at + 1], drift[at + 2] = x, y, z
    cx, cy, cz = crossed(wx, wy, wz, v[3], v[4], v[5])
    x, y, z = turned_back(T_a, bias[3] - cx, bias[4] - cy, bias[5] - cz)
    drift[at + 3], drift[at + 4], drift[at + 5] = x, y, z
