"""A grasp: two frames of the robot hold one rigid massless object, six rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import integers, matrix
from equipoise.contacts.alone import alone_of
from equipoise.contacts.base import WRENCH_LABELS, WRENCH_UNITS, KernelContact
from equipoise.contacts.view import GRASP, ContactView, frame_of, joint_of
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import (
    ACCELERATIONS,
    COLUMNS,
    VELOCITIES,
    acceleration_at,
    velocity_at,
)
from equipoise.kinematics.tree import CHAIN, CHAIN_COLUMN, CHAIN_COUNT, CHAIN_FIRST
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import crossed, rotation_difference, turned_back
from equipoise.spatial.poses import rigid

FACING = -0.5  # cosine between the z axes of two palms below which they face each other


@compiled
def grasp_rows(c: ContactView) -> None:
    """Write the twist of b as seen from a, and how far b is from its place in a.

    Both bodies are looked at in the origin of b, so that what moves both of them drops out.
    """
    T_a, T_b = frame_of(c.tree, c.state, c.first), frame_of(c.tree, c.state, c.second)
    held, phi, own = c.numbers, c.residual, c.own
    joint_a, joint_b = joint_of(c.tree, c.first), joint_of(c.tree, c.second)
    chain, first = integers(c.tree, CHAIN), integers(c.tree, CHAIN_FIRST)
    count = integers(c.tree, CHAIN_COUNT)
    for k in range(first[joint_a], first[joint_a] + count[joint_a]):
        for i in range(6):
            c.J[c.at + i, chain[k]] = 0.0
    for k in range(first[joint_b], first[joint_b] + count[joint_b]):
        for i in range(6):
            c.J[c.at + i, chain[k]] = 0.0
    add_seen(c, joint_a, T_a, T_b, -1.0)
    add_seen(c, joint_b, T_a, T_b, 1.0)
    px, py, pz = T_b[9], T_b[10], T_b[11]
    x, y, z = turned_back(T_a, px - T_a[9], py - T_a[10], pz - T_a[11])
    phi[own], phi[own + 1], phi[own + 2] = x - held[9], y - held[10], z - held[11]
    seen = scratch(12)  # the pose of b in a
    for k in range(3):
        x, y, z = turned_back(T_a, T_b[3 * k], T_b[3 * k + 1], T_b[3 * k + 2])
        seen[3 * k], seen[3 * k + 1], seen[3 * k + 2] = x, y, z
    phi[own + 3], phi[own + 4], phi[own + 5] = rotation_difference(seen, held)


@compiled
def add_seen(c: ContactView, joint: int, T_a: np.ndarray, T_b: np.ndarray, sign: float) -> None:
    """Add the twist, at the origin of b in axes of a, that moves a joint's body."""
    columns, chain, J, at = matrix(c.state, COLUMNS), integers(c.tree, CHAIN), c.J, c.at
    by, first = integers(c.tree, CHAIN_COLUMN), integers(c.tree, CHAIN_FIRST)[joint]
    for k in range(first, first + integers(c.tree, CHAIN_COUNT)[joint]):
        i, column = chain[k], columns[by[k]]
        wx, wy, wz = sign * column[3], sign * column[4], sign * column[5]
        x, y, z = crossed(wx, wy, wz, T_b[9], T_b[10], T_b[11])
        x, y, z = (
            x + sign * column[0],
            y + sign * column[1],
            z + sign * column[2],
        )
        x, y, z = turned_back(T_a, x, y, z)
        wx, wy, wz = turned_back(T_a, wx, wy, wz)
        J[at, i], J[at + 1, i], J[at + 2, i] = J[at, i] + x, J[at + 1, i] + y, J[at + 2, i] + z
        J[at + 3, i] += wx
        J[at + 4, i] += wy
        J[at + 5, i] += wz


@compiled
def grasp_drift(c: ContactView) -> None:
    """Write `dJ/dt v`: the relative acceleration at zero `dv/dt`, seen from the turning a.

    In axes that turn with omega, `x_seen'' = x'' - 2 omega x x_seen' - omega x (omega x x) -
    omega' x x`; the accelerations of a and b give the first and the last.
    """
    T_a, T_b = frame_of(c.tree, c.state, c.first), frame_of(c.tree, c.state, c.second)
    joint_a, joint_b = joint_of(c.tree, c.first), joint_of(c.tree, c.second)
    speeds, biases = matrix(c.state, VELOCITIES), matrix(c.state, ACCELERATIONS)
    speed_a, speed_b, bias_a, bias_b = (
        speeds[joint_a], speeds[joint_b], biases[joint_a], biases[joint_b]
    )  # fmt: skip
    ux, uy, uz = velocity_at(speed_a, T_a[9], T_a[10], T_a[11])
    vx, vy, vz = velocity_at(speed_b, T_b[9], T_b[10], T_b[11])
    vx, vy, vz = vx - ux, vy - uy, vz - uz
    ux, uy, uz = acceleration_at(speed_a, bias_a, T_a[9], T_a[10], T_a[11])
    ax, ay, az = acceleration_at(speed_b, bias_b, T_b[9], T_b[10], T_b[11])
    ax, ay, az = ax - ux, ay - uy, az - uz
    wx, wy, wz = speed_a[3], speed_a[4], speed_a[5]
    rx, ry, rz = T_b[9] - T_a[9], T_b[10] - T_a[10], T_b[11] - T_a[11]
    cx, cy, cz = crossed(wx, wy, wz, rx, ry, rz)
    # velocity as seen, and once more as it is: together the two middle terms
    cx, cy, cz = crossed(wx, wy, wz, 2.0 * vx - cx, 2.0 * vy - cy, 2.0 * vz - cz)
    ex, ey, ez = crossed(bias_a[3], bias_a[4], bias_a[5], rx, ry, rz)
    out, own = c.drift, c.own
    x, y, z = turned_back(T_a, ax - ex - cx, ay - ey - cy, az - ez - cz)
    out[own], out[own + 1], out[own + 2] = x, y, z
    cx, cy, cz = crossed(
        wx, wy, wz, speed_b[3] - wx, speed_b[4] - wy, speed_b[5] - wz
    )  # fmt: skip
    x, y, z = turned_back(
        T_a, bias_b[3] - bias_a[3] - cx, bias_b[4] - bias_a[4] - cy, bias_b[5] - bias_a[5] - cz
    )
    out[own + 3], out[own + 4], out[own + 5] = x, y, z


@dataclass(frozen=True, kw_only=True)
class GraspContact(KernelContact):
    """The pose of frame b relative to frame a stays at `T_a_b`.

    Rows and wrench are written in the axes of a, at the origin of b: `lam` is the wrench the
    object exerts on the body of b (and its opposite on the body of a). With the z axis of a
    pointing to b, `lam[2] >= 0` is a squeeze of the object.
    """

    frame_a: str | int
    frame_b: str | int
    T_a_b: pin.SE3

    def __post_init__(self) -> None:
        super().__post_init__()
        rigid(f"T_a_b of contact {self.name!r}", self.T_a_b)

    @classmethod
    def holding(
        cls,
        name: str,
        kin: Kinematics,
        frame_a: str | int,
        frame_b: str | int,
        *,
        regulated: tuple[str, ...] = (),
    ) -> GraspContact:
        """Return the grasp of an object between two frames as they are at the state of `kin`.

        Raises: NameNotFoundError if the robot has no such frame, the contact no such row.
        """
        T_a_b = kin.placement(frame_a).actInv(kin.placement(frame_b))
        return cls(name=name, regulated=regulated, frame_a=frame_a, frame_b=frame_b, T_a_b=T_a_b)

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""
        return WRENCH_LABELS

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""
        return WRENCH_UNITS

    @property
    def one_sided(self) -> frozenset[str]:
        """The squeeze, of palms that face each other (z axes apart by more than 120 degrees).

        A squeeze that is regulated is one whatever the palms look like.
        """
        facing = float(self.T_a_b.rotation[2, 2]) < FACING
        return frozenset({"fz"}) if facing or "fz" in self.regulated else frozenset()

    kind = GRASP
    alone = staticmethod(alone_of("grasp", grasp_rows, grasp_drift))

    @property
    def frames(self) -> tuple[str | int, str | int]:
        """Frames a and b."""
        return self.frame_a, self.frame_b

    @property
    def numbers(self) -> Array:
        """The pose of b in a as a row (12,)."""
        return pose_row(self.T_a_b)
