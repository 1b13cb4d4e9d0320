"""A sole: the pose of a frame is fixed in the world, six rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled
from equipoise.compiled.workspace import integers, matrix
from equipoise.contacts.alone import alone_of
from equipoise.contacts.base import WRENCH_LABELS, WRENCH_UNITS, KernelContact
from equipoise.contacts.view import SOLE, ContactView, frame_of, joint_of
from equipoise.errors import InputError
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import ACCELERATIONS, COLUMNS, VELOCITIES, acceleration_at
from equipoise.kinematics.tree import CHAIN, CHAIN_COLUMN, CHAIN_COUNT, CHAIN_FIRST
from equipoise.robots import Sole
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import crossed, rotation_difference, turned_back
from equipoise.spatial.numbers import real_number
from equipoise.spatial.poses import rigid

FRICTION = 0.7  # coefficient between a sole and the ground, unless another is given


@compiled
def sole_rows(c: ContactView) -> None:
    """Write the rows of a frame and how far it is from its anchor, in axes of the anchor."""
    T, anchor, J, at = frame_of(c.tree, c.state, c.first), c.numbers, c.J, c.at
    joint = joint_of(c.tree, c.first)
    columns, chain = matrix(c.state, COLUMNS), integers(c.tree, CHAIN)
    by, start = integers(c.tree, CHAIN_COLUMN), integers(c.tree, CHAIN_FIRST)[joint]
    px, py, pz = T[9], T[10], T[11]
    for k in range(start, start + integers(c.tree, CHAIN_COUNT)[joint]):
        i, column = chain[k], columns[by[k]]
        wx, wy, wz = column[3], column[4], column[5]
        lx, ly, lz = crossed(wx, wy, wz, px, py, pz)
        lx, ly, lz = lx + column[0], ly + column[1], lz + column[2]
        J[at, i], J[at + 1, i], J[at + 2, i] = turned_back(anchor, lx, ly, lz)
        J[at + 3, i], J[at + 4, i], J[at + 5, i] = turned_back(anchor, wx, wy, wz)
    phi, own = c.residual, c.own
    dx, dy, dz = px - anchor[9], py - anchor[10], pz - anchor[11]
    phi[own], phi[own + 1], phi[own + 2] = turned_back(anchor, dx, dy, dz)
    rx, ry, rz = rotation_difference(T, anchor)
    phi[own + 3], phi[own + 4], phi[own + 5] = turned_back(anchor, rx, ry, rz)


@compiled
def sole_drift(c: ContactView) -> None:
    """Write `dJ/dt v` in axes of the anchor."""
    T, anchor, out, own = frame_of(c.tree, c.state, c.first), c.numbers, c.drift, c.own
    joint = joint_of(c.tree, c.first)
    speed, bias = matrix(c.state, VELOCITIES)[joint], matrix(c.state, ACCELERATIONS)[joint]
    x, y, z = acceleration_at(speed, bias, T[9], T[10], T[11])
    out[own], out[own + 1], out[own + 2] = turned_back(anchor, x, y, z)
    out[own + 3], out[own + 4], out[own + 5] = turned_back(anchor, bias[3], bias[4], bias[5])


@dataclass(frozen=True, kw_only=True)
class SoleContact(KernelContact):
    """The frame of `sole` stays at `T_world_anchor`.

    Rows and wrench are written in the axes of the anchor, at the origin of the frame: with z up,
    `lam[2] >= 0` is compression.
    """

    sole: Sole
    friction: float = FRICTION
    T_world_anchor: pin.SE3

    def __post_init__(self) -> None:
        super().__post_init__()
        rigid(f"the anchor of contact {self.name!r}", self.T_world_anchor)
        if not real_number(f"the friction of contact {self.name!r}", self.friction) > 0.0:
            raise InputError(
                f"the friction of contact {self.name!r} must be positive", given=self.friction
            )

    @classmethod
    def standing(
        cls,
        sole: Sole,
        kin: Kinematics,
        *,
        name: str | None = None,
        supporting: bool = True,
        friction: float = FRICTION,
    ) -> SoleContact:
        """Return the contact of a sole that stands where it is at the state of `kin`.

        It is called as the sole is, unless a `name` is given.
        Raises: NameNotFoundError if the robot has no such frame.
        """
        return cls(
            name=sole.name if name is None else name,
            supporting=supporting,
            sole=sole,
            friction=friction,
            T_world_anchor=kin.placement(sole.frame),
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""
        return WRENCH_LABELS

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""
        return WRENCH_UNITS

    kind = SOLE
    alone = staticmethod(alone_of("sole", sole_rows, sole_drift))

    @property
    def frame(self) -> str:
        """The frame of the sole."""
        return self.sole.frame

    @property
    def frames(self) -> tuple[str | int, str | int]:
        """The frame of the sole, twice."""
        return self.sole.frame, self.sole.frame

    @property
    def numbers(self) -> Array:
        """The anchor as a pose row (12,)."""
        return pose_row(self.T_world_anchor)

    normal_row = 2

    def reaction_costs(self) -> tuple[Array, Array]:
        """Return the cost of each component: what it uses up of cone and sole.

        A tangential force counts by the normal force that its friction needs, a moment by the
        normal force that the lever of the sole needs, a yaw moment by both, all relative to the
        load that is there: a light foot can give little. A normal force counts a little, so that
        both feet carry.
        """
        half_x = 0.5 * (self.sole.x_max - self.sole.x_min)
        half_y = 0.5 * (self.sole.y_max - self.sole.y_min)
        tangential = 1.0 / self.friction
        yaw = tangential / (half_x + half_y)
        over_load = np.array([tangential, tangential, 0.0, 1.0 / half_y, 1.0 / half_x, yaw])
        return np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0]), over_load
