"""Supporting forces that a floor can give: the base wrench shared out within bounds.

Among all F with `J_b^T F = u_b` the one is taken whose predicted reaction `lam_0 + F` presses,
stays in the friction cones, keeps its centres of pressure in the soles, and costs least. What
cannot be kept is violated as little as possible, in the least-squares sense over all bounds [N].
Geometry only.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from equipoise.compiled import entrance, scratch
from equipoise.compiled.workspace import Part, Shape, Workspace, part_of
from equipoise.contacts import Contact, PointContact, SoleContact
from equipoise.control.base_wrench.bounded_kernels import (
    LANDED,
    SLACK,
    STATUS,
    WARN,
    bounded_reaction,
    bounds_shapes,
)
from equipoise.errors import InputError
from equipoise.hqp.solvers.active_set.memory import (
    SEARCH_MEMORY,
    SOLVED,
    rows_shapes,
    search_shapes,
)
from equipoise.hqp.solvers.active_set.solve import SOLVE
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, share

Foot = SoleContact | PointContact

_SIDES = 8
BASE = 6  # rows of the base wrench, at most
SETTLED = 0.1  # [s] before it a released robot has not caught its weight: every sole is light


@dataclass(frozen=True)
class ReactionBounds:
    """How far from the edge a predicted reaction is kept.

    `normal_min` [N] on each sole; `friction_share` of the cone; `pressure_margin` [m] of the
    centre of pressure to the edges; `warn` [N]: how close to a bound a sole is reported.
    """

    normal_min: float = 10.0
    friction_share: float = 0.9
    pressure_margin: float = 0.005
    warn: float = 10.0

    def __post_init__(self) -> None:
        for name in ("normal_min", "pressure_margin", "warn"):
            not_negative(name, getattr(self, name))
        share("friction_share", self.friction_share)


class DistributionStatus(Enum):
    """How the distribution went; the value is a sentence."""

    POSSIBLE = "the floor can give the predicted reaction"
    SLACK = "no distribution keeps every bound; the least violation was taken"
    FAILED = "the hierarchy gave no answer within its limit"


@dataclass(frozen=True)
class Distribution:
    """`F` (k,), the predicted reaction (k,), the largest violation of a bound [N], how it went.

    `warnings` say what soles are about to do: bounds that are nearer than `ReactionBounds.warn`.
    """

    F: Array
    predicted: Array
    slack: float
    status: DistributionStatus
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class BoundRows:
    """`A lam >= b` (m,), in newtons, with what happens to the sole if a row is broken."""

    A: Array
    b: Array
    what: tuple[str, ...]


class BoundsProgram:
    """The bounds of at most `supports` supporting soles, laid out in three parts of a workspace."""

    names = ("bounds", "bound_rows", "bound_search")

    def __init__(self, bounds: ReactionBounds, unknowns: int, rows: int) -> None:
        self.bounds, self.unknowns, self.rows = bounds, max(unknowns, 1), rows
        self.what: tuple[str, ...] = ()

    def shapes(self) -> dict[str, list[tuple[str, Shape, bool]]]:
        """Return the arrays of the three parts."""
        m = BASE + self.rows
        return dict(
            zip(
                self.names,
                (
                    bounds_shapes(self.rows, self.unknowns),
                    rows_shapes(m, self.unknowns, 2),
                    search_shapes(m, self.unknowns, 2),
                ),
                strict=True,
            )
        )

    def fill(self, workspace: Workspace, supports: Sequence[Contact], base: int) -> None:
        """Write the constants for the soles that support now; what they leave over stays free.

        Raises: `InputError` if a supporting contact is neither sole nor point.
        """
        soles = require_feet(supports)
        own, rows, search = (workspace.parts[name] for name in self.names)
        self._clear(own, rows, search, base)
        row, column = base, 0
        what: list[str] = []
        for sole in soles:
            found = bounds_of(sole, self.bounds)
            columns = slice(column, column + sole.size)
            own.sides[row - base : row - base + len(found.b), columns] = found.A
            own.limits[row - base : row - base + len(found.b)] = found.b
            rows.first[row : row + len(found.b)] = columns.start
            rows.last[row : row + len(found.b)] = columns.stop
            row, column, what = row + len(found.b), columns.stop, [*what, *found.what]
        self.what = tuple(what)
        own.numbers[WARN], own.numbers[LANDED] = self.bounds.warn, SETTLED

    def _clear(self, own: Part, rows: Part, search: Part, base: int) -> None:
        own.sides[:], own.limits[:], own.near_since[:] = 0.0, -np.inf, np.inf
        rows.A[:], rows.lower[:], rows.upper[:] = 0.0, -np.inf, np.inf
        rows.ends[:] = base, len(rows.lower)
        rows.first[:], rows.last[:], rows.single[:] = 0, self.unknowns, -1
        for name in SEARCH_MEMORY:  # zeros are a cold start
            getattr(search, name)[...] = 0
        search.counts[:] = 1

    def notes(self, own: Part) -> dict[str, float]:
        """Return what a sole was about to do, in words, and since when [s]."""
        found: dict[str, float] = {}
        for what, since in zip(self.what, own.near_since, strict=False):
            if np.isfinite(since):
                found[what] = min(found.get(what, np.inf), float(since))
        return dict(sorted(found.items(), key=lambda note: note[1]))


@entrance
def bounded_alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, J: np.ndarray,
    supporting: np.ndarray, u: np.ndarray, costs: np.ndarray, without: np.ndarray, F: np.ndarray,
) -> None:  # fmt: skip
    """Share out one wrench within bounds, called from Python."""
    bounds, rows, search = (
        part_of(floats, whole, tables, 0),
        part_of(floats, whole, tables, 1),
        part_of(floats, whole, tables, 2),
    )
    wish = scratch(F.shape[0])
    wish[:] = 0.0
    bounded_reaction(
        bounds, rows, search, J, supporting, u, costs, without, wish, wish, 0.0, u.shape[0], 0.0, F
    )


class BoundedDistribution:
    """Distributes over given soles; build it once.

    Raises: `InputError` if a supporting contact is neither sole nor point.
    """

    def __init__(self, soles: Sequence[Contact], bounds: ReactionBounds | None = None) -> None:
        self.soles = require_feet(soles)
        self.bounds = bounds or ReactionBounds()
        rows = sum(len(bounds_of(sole, self.bounds).b) for sole in self.soles)
        unknowns = sum(sole.size for sole in self.soles)
        self._program = BoundsProgram(self.bounds, unknowns, rows)
        self._workspace = Workspace(self._program.shapes(), stages=[SOLVE])
        self._program.fill(self._workspace, self.soles, BASE)

    def __call__(
        self, u_base: Array, J_base: Array, lam_0: Array, costs: Array | None = None
    ) -> Distribution:
        """Return the distribution of `u_base` (6,) over the rows of `J_base` (k, 6).

        `lam_0` (k,) is the reaction that would act with F = 0; `costs` (k,) > 0 of each component,
        by default those of equal loads.
        """
        if costs is None:
            costs = np.concatenate([sum(sole.reaction_costs()) for sole in self.soles])
        F, workspace = np.empty(len(lam_0)), self._workspace
        blocks = workspace.floats, workspace.integers, workspace.tables
        J, without = np.ascontiguousarray(J_base, dtype=float), np.array(lam_0, dtype=float)
        u, c = np.array(u_base, dtype=float), np.array(costs, dtype=float)
        bounded_alone(*blocks, J, np.arange(len(F)), u, c, without, F)
        own = workspace.parts["bounds"]
        predicted = own.predicted.copy()
        return Distribution(
            F, predicted, float(own.numbers[SLACK]), status_of(own.numbers), self._near(predicted)
        )

    def _near(self, predicted: Array) -> tuple[str, ...]:
        """Return what is about to happen to the soles under a reaction (k,)."""
        found: dict[str, None] = {}
        start = 0
        for sole in self.soles:
            rows = bounds_of(sole, self.bounds)
            left = rows.A @ predicted[start : start + sole.size] - rows.b
            near = np.flatnonzero(left < self.bounds.warn)
            found |= dict.fromkeys(rows.what[k] for k in near)
            start += sole.size
        return tuple(found)


def status_of(numbers: Array) -> DistributionStatus:
    """Return how the last distribution went, from the numbers of its part."""
    if numbers[STATUS] != SOLVED:
        return DistributionStatus.FAILED
    return DistributionStatus.SLACK if numbers[SLACK] > 1e-3 else DistributionStatus.POSSIBLE


def require_feet(contacts: Sequence[Contact]) -> tuple[Foot, ...]:
    """Return the contacts if all are soles or points. Raises: `InputError`."""
    feet = tuple(contact for contact in contacts if isinstance(contact, SoleContact | PointContact))
    others = [c.name for c in contacts if not isinstance(c, SoleContact | PointContact)]
    if others:
        raise InputError(
            "only soles and feet that are points can share out the base wrench within bounds",
            given=others,
            remedy="Leave the bounds out, or let soles and points support the base only",
        )
    return feet


def bounds_of(foot: Foot, bounds: ReactionBounds) -> BoundRows:
    """Return the rows of one foot: of a sole on its wrench (6,), of a point on its force (3,)."""
    rows, offsets = [np.eye(foot.size)[2]], [bounds.normal_min]
    what = [f"{foot.name} lifts"]
    reach = bounds.friction_share * foot.friction * np.cos(np.pi / _SIDES)
    for angle in 2.0 * np.pi * np.arange(_SIDES) / _SIDES:
        row = np.zeros(foot.size)
        row[:3] = -np.cos(angle), -np.sin(angle), reach
        rows.append(row)
        offsets.append(0.0)
        what.append(f"{foot.name} slips")
    found = BoundRows(np.array(rows), np.array(offsets), tuple(what))
    return found if isinstance(foot, PointContact) else _with_moments(found, foot, bounds)


def _with_moments(found: BoundRows, sole: SoleContact, bounds: ReactionBounds) -> BoundRows:
    """Return the rows of a sole with those on its moments, in the axes of the sole."""
    s, friction = sole.sole, bounds.friction_share * sole.friction
    name = sole.name
    rows, offsets, what = [*found.A.tolist()], [*found.b.tolist()], [*found.what]

    def add(row: Iterable[float], sentence: str) -> None:
        rows.append(list(row))
        offsets.append(0.0)
        what.append(f"{name} {sentence}")

    m = bounds.pressure_margin
    half_x, half_y = 0.5 * (s.x_max - s.x_min), 0.5 * (s.y_max - s.y_min)
    x, y = 1.0 / half_x, 1.0 / half_y
    add((0, 0, (s.x_max - m) * x, 0, x, 0), "tips over its front edge")
    add((0, 0, -(s.x_min + m) * x, 0, -x, 0), "tips over its rear edge")
    add((0, 0, (s.y_max - m) * y, -y, 0, 0), "tips over its left edge")
    add((0, 0, -(s.y_min + m) * y, y, 0, 0), "tips over its right edge")
    for row in _yaw_rows(sole, friction):
        add(row, "turns")
    return BoundRows(np.array(rows, dtype=float), np.array(offsets), tuple(what))


def _yaw_rows(sole: SoleContact, friction: float) -> list[Array]:
    """Return the eight rows that bound the yaw moment (see `contacts.reaction_margins`)."""
    s = sole.sole
    half_x, half_y = 0.5 * (s.x_max - s.x_min), 0.5 * (s.y_max - s.y_min)
    centre_x, centre_y = 0.5 * (s.x_max + s.x_min), 0.5 * (s.y_max + s.y_min)
    fx, fy, fz, mx, my, mz = np.eye(6)
    mx_c, my_c = mx - centre_y * fz, my + centre_x * fz
    mz_c = mz - (centre_x * fy - centre_y * fx)
    reach = friction * (half_x + half_y)
    rows = []
    for turn in (1.0, -1.0):
        across, along = half_y * fx + turn * friction * mx_c, half_x * fy + turn * friction * my_c
        for a in (1.0, -1.0):
            for b in (1.0, -1.0):
                rows.append((reach * fz - a * across - b * along - turn * mz_c) / reach)
    return rows
