"""A point of the robot slides without friction on a smooth surface, at rest or moving: a row."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import matrix
from equipoise.contacts.alone import alone_of
from equipoise.contacts.base import ORIGIN, KernelContact
from equipoise.contacts.body_point import point_position, require_offset
from equipoise.contacts.surfaces import Surface
from equipoise.contacts.surfaces.dispatch import sample_surface
from equipoise.contacts.surfaces.sample import GRADIENT, HESSIAN, OWN, VALUE, KernelSurface
from equipoise.contacts.view import SLIDING, ContactView, frame_of, joint_of
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import (
    ACCELERATIONS,
    VELOCITIES,
    acceleration_at,
    add_point_row,
    clear_row,
    velocity_at,
)
from equipoise.spatial import Array
from equipoise.spatial.kernels import crossed, turned, turned_back

TWIST, TWIST_RATE = 12, 18  # where they begin in a place


@compiled
def look_at_surface(c: ContactView, p: np.ndarray) -> float:
    """Write where the contact point is, sample the surface there, return its steepness.

    The numbers are the offset of the point and the lengths of the surface.
    """
    T, place = frame_of(c.tree, c.state, c.first), c.place
    rx, ry, rz = turned(T, c.numbers[0], c.numbers[1], c.numbers[2])
    p[0], p[1], p[2] = T[9] + rx, T[10] + ry, T[11] + rz
    x, y, z = turned_back(place, p[0] - place[9], p[1] - place[10], p[2] - place[11])
    sample_surface(c.surface, c.numbers[3:6], x, y, z, c.sample)
    g = c.sample[GRADIENT:HESSIAN]
    return math.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])


@compiled
def sliding_rows(c: ContactView) -> None:
    """Write `n J_point`, the speed of the surface along n, and the distance to first order."""
    p, n, place = scratch(3), scratch(3), c.place
    steepness = look_at_surface(c, p)
    nx, ny, nz = turned(place, c.sample[1], c.sample[2], c.sample[3])
    n[0], n[1], n[2] = nx / steepness, ny / steepness, nz / steepness
    joint = joint_of(c.tree, c.first)
    clear_row(c.tree, joint, c.J, c.at)
    add_point_row(c.tree, c.state, joint, p, n, 1.0, c.J, c.at)
    x, y, z = carried_along(place, TWIST, p[0] - place[9], p[1] - place[10], p[2] - place[11])
    c.rate[c.own] = n[0] * x + n[1] * y + n[2] * z
    c.residual[c.own] = c.sample[VALUE] / steepness


@compiled
def carried_along(
    place: np.ndarray, first: int, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Return v + omega x lever of place[first : first + 6] = (v, omega) and the lever (x, y, z)."""
    cx, cy, cz = crossed(place[first + 3], place[first + 4], place[first + 5], x, y, z)
    return place[first] + cx, place[first + 1] + cy, place[first + 2] + cz


@compiled
def sliding_drift(c: ContactView) -> None:
    """Write `d(J v - rate)/dt` at zero `dv/dt`, as seen from the surface's axes, which may turn.

    Relative acceleration along the normal, with the Coriolis and centrifugal terms of these axes,
    and the normal turning as the point moves: `dn/dt = (I - n n^T) Hess xdot / |grad|`.
    """
    p, place, joint = scratch(3), c.place, joint_of(c.tree, c.first)
    steepness = look_at_surface(c, p)
    speed, bias = matrix(c.state, VELOCITIES)[joint], matrix(c.state, ACCELERATIONS)[joint]
    wx, wy, wz = place[TWIST + 3], place[TWIST + 4], place[TWIST + 5]
    lx, ly, lz = p[0] - place[9], p[1] - place[10], p[2] - place[11]
    vx, vy, vz = velocity_at(speed, p[0], p[1], p[2])
    x, y, z = carried_along(place, TWIST, lx, ly, lz)
    vx, vy, vz = vx - x, vy - y, vz - z
    ax, ay, az = acceleration_at(speed, bias, p[0], p[1], p[2])
    x, y, z = carried_along(place, TWIST_RATE, lx, ly, lz)
    ax, ay, az = ax - x, ay - y, az - z
    # omega x (omega x lever) + 2 omega x relative: the two in one product
    x, y, z = crossed(wx, wy, wz, lx, ly, lz)
    x, y, z = crossed(wx, wy, wz, x + 2.0 * vx, y + 2.0 * vy, z + 2.0 * vz)
    s = scratch(3)
    s[0], s[1], s[2] = turned_back(place, vx, vy, vz)
    rx, ry, rz = turned_back(place, ax - x, ay - y, az - z)
    gradient, hessian = c.sample[GRADIENT:HESSIAN], c.sample[HESSIAN:]
    along = bent_along = bent_across = 0.0
    for i in range(3):
        n = gradient[i] / steepness
        k = 3 * i
        bent = hessian[k] * s[0] + hessian[k + 1] * s[1] + hessian[k + 2] * s[2]
        bent /= steepness
        along += n * s[i]
        bent_along += n * bent
        bent_across += bent * s[i]
    wanted = (gradient[0] * rx + gradient[1] * ry + gradient[2] * rz) / steepness
    c.drift[c.own] = wanted + bent_across - bent_along * along


@dataclass(frozen=True, kw_only=True)
class SlidingContact(KernelContact):
    """The point `offset` [m] of `frame` stays on `surface`, wherever that is.

    The row is `n . velocity` with the unit normal n out of the object toward the robot, so that
    the multiplier is the normal force [N], compression positive. A surface of one's own is asked
    from Python every tick.
    Source: eq. (13) and the rows below it. Differs from the print: `J_phix` is divided by
    `|grad phi|`, and with it the multiplier becomes a force in newtons for any phi.
    """

    frame: str | int
    surface: Surface
    offset: tuple[float, float, float] = ORIGIN
    kind = SLIDING
    alone = staticmethod(alone_of("sliding", sliding_rows, sliding_drift))

    def __post_init__(self) -> None:
        super().__post_init__()
        require_offset(self.name, self.offset)

    @property
    def frames(self) -> tuple[str | int, str | int]:
        """The frame of the point, twice."""
        return self.frame, self.frame

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of the multiplier."""
        return ("fn",)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of the multiplier."""
        return ("N",)

    normal_row = 0

    @property
    def surface_kind(self) -> int:
        """Which surface it is, as kernels know it."""
        return self.surface.kind if isinstance(self.surface, KernelSurface) else OWN

    @cached_property
    def numbers(self) -> Array:
        """The offset and the lengths of the surface (6,)."""
        lengths = self.surface.numbers if isinstance(self.surface, KernelSurface) else np.zeros(3)
        return np.concatenate((self.offset, lengths))

    @abstractmethod
    def place(self, t: float) -> Array:
        """Return where the surface is and how it moves at time `t` [s] (24,), in world axes.

        Its pose row, its twist and the time derivative of that.
        """

    def position(self, kin: Kinematics) -> Array:
        """Return where the contact point is in the world (3,) [m]."""
        return point_position(kin, self.frame, self.offset)

    def normal(self, kin: Kinematics) -> Array:
        """Return the unit normal (3,) in world axes, out of the object toward the robot.

        Raises: `VanishingGradientError`.
        """
        R, x = self._seen(kin)
        return R @ self.surface.normal(x)

    def sample(self, kin: Kinematics) -> Array:
        """Return value, gradient and Hessian (13,) at the contact point.

        Raises: `VanishingGradientError`.
        """
        _, x = self._seen(kin)
        surface = self.surface
        surface.steepness(x)
        if isinstance(surface, KernelSurface):
            return surface.sample(x)
        hessian = np.asarray(surface.hessian(x), dtype=float).ravel()
        return np.concatenate(([surface.value(x)], surface.gradient(x), hessian))

    def _seen(self, kin: Kinematics) -> tuple[Array, Array]:
        """Return the rotation (3, 3) of the surface and the contact point (3,) in its axes."""
        place = self.place(kin.t)
        R = place[:9].reshape(3, 3).T
        return R, R.T @ (self.position(kin) - place[9:12])
