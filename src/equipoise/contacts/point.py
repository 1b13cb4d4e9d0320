"""A point contact: a point of a frame stays where it is in the world, three rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.compiled import compiled
from equipoise.compiled.workspace import integers, matrix
from equipoise.contacts.alone import alone_of
from equipoise.contacts.base import ORIGIN, WRENCH_LABELS, WRENCH_UNITS, KernelContact
from equipoise.contacts.body_point import require_offset
from equipoise.contacts.view import POINT, ContactView, frame_of, joint_of
from equipoise.errors import InputError
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import ACCELERATIONS, COLUMNS, VELOCITIES, acceleration_at
from equipoise.kinematics.tree import CHAIN, CHAIN_COLUMN, CHAIN_COUNT, CHAIN_FIRST
from equipoise.spatial import Array
from equipoise.spatial.kernels import crossed, turned
from equipoise.spatial.numbers import real_array, real_number

FRICTION = 0.7  # coefficient between a foot and the ground, unless another is given


@compiled
def point_rows(c: ContactView) -> None:
    """Write the velocity of a point of a frame, and how far it is from its place."""
    T, kept, J, at = frame_of(c.tree, c.state, c.first), c.numbers, c.J, c.at
    joint = joint_of(c.tree, c.first)
    columns, chain = matrix(c.state, COLUMNS), integers(c.tree, CHAIN)
    by, start = integers(c.tree, CHAIN_COLUMN), integers(c.tree, CHAIN_FIRST)[joint]
    rx, ry, rz = turned(T, kept[0], kept[1], kept[2])
    px, py, pz = T[9] + rx, T[10] + ry, T[11] + rz
    for k in range(start, start + integers(c.tree, CHAIN_COUNT)[joint]):
        i, column = chain[k], columns[by[k]]
        x, y, z = crossed(column[3], column[4], column[5], px, py, pz)
        J[at, i], J[at + 1, i] = column[0] + x, column[1] + y
        J[at + 2, i] = column[2] + z
    phi, own = c.residual, c.own
    phi[own], phi[own + 1], phi[own + 2] = px - kept[3], py - kept[4], pz - kept[5]


@compiled
def point_drift(c: ContactView) -> None:
    """Write `dJ/dt v`: the acceleration of the point at zero `dv/dt`."""
    T, kept, joint = frame_of(c.tree, c.state, c.first), c.numbers, joint_of(c.tree, c.first)
    rx, ry, rz = turned(T, kept[0], kept[1], kept[2])
    speed, bias = matrix(c.state, VELOCITIES)[joint], matrix(c.state, ACCELERATIONS)[joint]
    x, y, z = acceleration_at(speed, bias, T[9] + rx, T[10] + ry, T[11] + rz)
    c.drift[c.own], c.drift[c.own + 1], c.drift[c.own + 2] = x, y, z


@dataclass(frozen=True, kw_only=True)
class PointContact(KernelContact):
    """The point `offset` [m] of `frame` stays at `p_world` (3,) [m].

    Rows and force are in world axes; the frame may turn about the point. One that is `supporting`
    is a foot on level ground: it can only push, along z, within the cone of its `friction`.
    """

    frame: str | int
    p_world: Array
    offset: tuple[float, float, float] = ORIGIN
    friction: float = FRICTION

    def __post_init__(self) -> None:
        super().__post_init__()
        require_offset(self.name, self.offset)
        real_array(f"p_world of contact {self.name!r}", self.p_world, (3,))
        if not real_number(f"the friction of contact {self.name!r}", self.friction) > 0.0:
            raise InputError(
                f"the friction of contact {self.name!r} must be positive", given=self.friction
            )

    @classmethod
    def standing(
        cls, frame: str, kin: Kinematics, *, name: str | None = None, friction: float = FRICTION
    ) -> PointContact:
        """Return a supporting foot whose point, the origin of `frame`, stays where it is at `kin`.

        It is called as the frame is, unless a `name` is given. Raises: `NameNotFoundError`.
        """
        return cls(
            name=frame if name is None else name,
            supporting=True,
            frame=frame,
            friction=friction,
            p_world=kin.placement(frame).translation,
        )

    @property
    def normal_row(self) -> int | None:
        """The row of z if it stands on the ground; a point that is held elsewhere has none."""
        return 2 if self.supporting else None

    def reaction_costs(self) -> tuple[Array, Array]:
        """Return the cost of each component, as for a sole: what it uses up of the cone."""
        if not self.supporting:
            return super().reaction_costs()
        tangential = 1.0 / self.friction
        return np.array([0.0, 0.0, 0.3]), np.array([tangential, tangential, 0.0])

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""
        return WRENCH_LABELS[:3]

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""
        return WRENCH_UNITS[:3]

    kind = POINT
    alone = staticmethod(alone_of("point", point_rows, point_drift))

    @property
    def frames(self) -> tuple[str | int, str | int]:
        """The frame of the point, twice."""
        return self.frame, self.frame

    @property
    def numbers(self) -> Array:
        """The offset and where it stays (6,)."""
        return np.concatenate((self.offset, self.p_world))
