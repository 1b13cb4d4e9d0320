"""A point of the robot that slides without friction on a smooth surface, at rest or moving: a row.

The surface says phi with gradient and Hessian in plain Python, so that a surface of one's own is
one small class; a kernel makes the row of them.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.scratch import scratch, scratch_matrix
from equipoise.contacts.base import RowsContact
from equipoise.contacts.body_point import ORIGIN, point_position, require_offset
from equipoise.contacts.rows import ContactRows
from equipoise.contacts.surfaces import Surface
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import add_point_row, frame_motion
from equipoise.spatial import Array
from equipoise.spatial.kernels import crossed, turned, turned_back


@dataclass(frozen=True, kw_only=True)
class SlidingContact(RowsContact):
    """The point `offset` [m] of frame `frame_id` stays on `surface`, wherever that is.

    The row is `n . velocity` with the unit normal n out of the object toward the robot, so that
    the multiplier is the normal force [N], compression positive.
    Source: eq. (13) and the rows below it. Differs from the print: `J_phix` is divided by
    `|grad phi|`, and with it the multiplier becomes a force in newtons for any phi.
    """

    frame_id: int
    surface: Surface
    offset: tuple[float, float, float] = ORIGIN

    def __post_init__(self) -> None:
        super().__post_init__()
        require_offset(self.name, self.offset)
        object.__setattr__(self, "_offset", np.array(self.offset, dtype=float))

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of the multiplier."""
        return ("fn",)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of the multiplier."""
        return ("N",)

    @abstractmethod
    def place(self, t: float) -> Array:
        """Return where the surface is and how it moves at time `t` [s] (24,), in world axes.

        Its pose row, its twist and the time derivative of that.
        """

    def position(self, kin: Kinematics) -> Array:
        """Return where the contact point is in the world (3,) [m]."""
        return point_position(kin, self.frame_id, self.offset)

    def normal(self, kin: Kinematics) -> Array:
        """Return the unit normal (3,) in world axes, out of the object toward the robot."""
        R = self.place(kin.t)[:9].reshape(3, 3).T
        return R @ self.surface.normal(self._seen(kin, self.place(kin.t)))

    def fill(self, kin: Kinematics, rows: ContactRows, at: int, *, drift: bool = False) -> None:
        """Write the row at `at`; its drift only if asked for. Raises: `VanishingGradientError`."""
        place, surface = self.place(kin.t), self.surface
        x = self._seen(kin, place)
        steepness, gradient = surface.steepness(x), np.array(surface.gradient(x), dtype=float)
        live = kin.live_with_drift if drift else kin.live
        joint = live.joint_of[self.frame_id]
        sliding_row(
            live.columns,
            live.carries[joint],
            live.frames[self.frame_id],
            self._offset,
            place,
            float(surface.value(x)),
            steepness,
            gradient,
            rows.J,
            rows.rate,
            rows.residual,
            at,
        )
        if drift:
            sliding_drift(
                live.joints[joint],
                live.velocities[joint],
                live.accelerations[joint],
                live.frames[self.frame_id],
                self._offset,
                place,
                steepness,
                gradient,
                np.array(surface.hessian(x), dtype=float),
                rows.drift,
                at,
            )

    def _seen(self, kin: Kinematics, place: Array) -> Array:
        """Return the contact point (3,) in coordinates of the surface."""
        x = np.empty(3)
        seen_from(kin.live.frames[self.frame_id], self._offset, place, x)
        return x


@compiled
def point_of(T: np.ndarray, offset: np.ndarray) -> tuple[float, float, float]:
    """Return where the point at `offset` [3] of a frame at T is."""
    rx, ry, rz = turned(T, offset[0], offset[1], offset[2])
    return T[9] + rx, T[10] + ry, T[11] + rz


@entrance
def seen_from(T: np.ndarray, offset: np.ndarray, place: np.ndarray, x: np.ndarray) -> None:
    """Write to x [3] the point at `offset` of a frame at T in coordinates of the surface."""
    px, py, pz = point_of(T, offset)
    x[0], x[1], x[2] = turned_back(place, px - place[9], py - place[10], pz - place[11])


@entrance
def sliding_row(
    columns: np.ndarray,
    carried: np.ndarray,
    T: np.ndarray,
    offset: np.ndarray,
    place: np.ndarray,
    value: float,
    steepness: float,
    gradient: np.ndarray,
    J: np.ndarray,
    rate: np.ndarray,
    residual: np.ndarray,
    at: int,
) -> None:
    """Write `n J_point`, the speed of the surface along n, and the distance to first order."""
    p, n = scratch(3), scratch(3)
    p[0], p[1], p[2] = point_of(T, offset)
    n[0], n[1], n[2] = turned(place, gradient[0], gradient[1], gradient[2])
    for i in range(3):
        n[i] /= steepness
    for c in range(J.shape[1]):
        J[at, c] = 0.0
    add_point_row(columns, carried, p, n, 1.0, J, at)
    cx, cy, cz = carried_along(place, 12, p[0] - place[9], p[1] - place[10], p[2] - place[11])
    rate[at] = n[0] * cx + n[1] * cy + n[2] * cz
    residual[at] = value / steepness


@compiled
def carried_along(
    place: np.ndarray, first: int, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Return v + omega x lever of place[first : first + 6] = (v, omega) and the lever (x, y, z)."""
    cx, cy, cz = crossed(place[first + 3], place[first + 4], place[first + 5], x, y, z)
    return place[first] + cx, place[first + 1] + cy, place[first + 2] + cz


@entrance
def sliding_drift(
    joint: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    T: np.ndarray,
    offset: np.ndarray,
    place: np.ndarray,
    steepness: float,
    gradient: np.ndarray,
    hessian: np.ndarray,
    drift: np.ndarray,
    at: int,
) -> None:
    """Write `d(J v - rate)/dt` at zero `dv/dt`, as seen from the surface's axes, which may turn.

    Relative acceleration along the normal, with the Coriolis and centrifugal terms of these axes,
    and the normal turning as the point moves: `dn/dt = (I - n n^T) Hess xdot / |grad|`.
    """
    there, motion = scratch(12), scratch_matrix(2, 6)
    for i in range(9):
        there[i] = T[i]
    there[9], there[10], there[11] = point_of(T, offset)
    frame_motion(joint, velocity, acceleration, there, motion)
    wx, wy, wz = place[15], place[16], place[17]
    lx, ly, lz = there[9] - place[9], there[10] - place[10], there[11] - place[11]
    cx, cy, cz = carried_along(place, 12, lx, ly, lz)
    vx, vy, vz = motion[0, 0] - cx, motion[0, 1] - cy, motion[0, 2] - cz
    ax, ay, az = carried_along(place, 18, lx, ly, lz)
    # omega x (omega x lever) + 2 omega x relative: the two in one product
    sx, sy, sz = crossed(wx, wy, wz, lx, ly, lz)
    fx, fy, fz = crossed(wx, wy, wz, sx + 2.0 * vx, sy + 2.0 * vy, sz + 2.0 * vz)
    x = scratch(3)
    x[0], x[1], x[2] = turned_back(place, vx, vy, vz)
    rx, ry, rz = turned_back(
        place, motion[1, 0] - ax - fx, motion[1, 1] - ay - fy, motion[1, 2] - az - fz
    )
    along = bent_along = bent_across = 0.0
    for i in range(3):
        n = gradient[i] / steepness
        bent = (hessian[i, 0] * x[0] + hessian[i, 1] * x[1] + hessian[i, 2] * x[2]) / steepness
        along += n * x[i]
        bent_along += n * bent
        bent_across += bent * x[i]
    wanted = (gradient[0] * rx + gradient[1] * ry + gradient[2] * rz) / steepness
    drift[at] = wanted + bent_across - bent_along * along
