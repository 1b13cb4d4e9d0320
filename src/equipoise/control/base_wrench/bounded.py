"""Supporting forces that a floor can give: the base wrench shared out within bounds.

Among all F with `J_b^T F = u_b` the one is taken whose predicted reaction `lam_0 + F` presses,
stays in the friction cones, keeps its centres of pressure in the soles, leaves the joints that
carry torques that their motors have, and costs least. What cannot be kept is violated as little as
possible, in the least-squares sense over all bounds of the floor [N], then of the motors [N m].
Geometry only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from equipoise.compiled import entrance, scratch
from equipoise.compiled.workspace import Part, Shape, Workspace, part_of
from equipoise.contacts import Contact
from equipoise.control.base_wrench.bounded_kernels import (
    LANDED,
    SLACK,
    STATUS,
    TORQUE_SHARE,
    WARN,
    bounded_reaction,
    bounds_shapes,
)
from equipoise.control.base_wrench.foot_bounds import (
    Foot,
    ReactionBounds,
    bounds_of,
    require_feet,
)
from equipoise.hqp.solvers.active_set.memory import (
    SEARCH_MEMORY,
    SOLVED,
    rows_shapes,
    search_shapes,
)
from equipoise.hqp.solvers.active_set.solve import SOLVE
from equipoise.robots import Robot
from equipoise.spatial import Array

BASE = 6  # rows of the base wrench, at most
LEVELS = 3  # the wrench, the floor, the motors
SETTLED = 0.1  # [s] before it a released robot has not caught its weight: every sole is light


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


class BoundsProgram:
    """The bounds of at most `supports` supporting soles, laid out in three parts of a workspace."""

    names = ("bounds", "bound_rows", "bound_search")

    def __init__(self, bounds: ReactionBounds, unknowns: int, rows: int, joints: int = 0) -> None:
        self.bounds, self.unknowns, self.rows = bounds, max(unknowns, 1), rows
        self.joints = joints
        self.what: tuple[str, ...] = ()

    def shapes(self) -> dict[str, list[tuple[str, Shape, bool]]]:
        """Return the arrays of the three parts."""
        m = BASE + max(self.rows, 1) + self.joints
        return dict(
            zip(
                self.names,
                (
                    bounds_shapes(self.rows, self.unknowns, self.joints),
                    rows_shapes(m, self.unknowns, LEVELS),
                    search_shapes(m, self.unknowns, LEVELS),
                ),
                strict=True,
            )
        )

    def fill(
        self,
        workspace: Workspace,
        supports: Sequence[Contact],
        base: int,
        carriers: Sequence[Sequence[int]] = (),
    ) -> None:
        """Write the constants for the soles that support now; what they leave over stays free.

        `carriers` are for each of them the joints between it and the base.
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
        self._fill_motors(own, rows, soles, base, carriers)
        own.numbers[WARN], own.numbers[LANDED] = self.bounds.warn, SETTLED
        own.numbers[TORQUE_SHARE] = self.bounds.torque_share

    def _fill_motors(
        self,
        own: Part,
        rows: Part,
        soles: Sequence[Foot],
        base: int,
        carriers: Sequence[Sequence[int]],
    ) -> None:
        """Give each joint that carries a row over the reactions that it carries."""
        start, column = base + len(own.sides), 0
        first: dict[int, int] = {}
        last: dict[int, int] = {}
        for sole, joints in zip(soles, carriers, strict=False):
            for joint in joints:
                first.setdefault(joint, column)
                last[joint] = column + sole.size
            column += sole.size
        for n, joint in enumerate(first):
            own.carriers[n] = joint
            rows.first[start + n], rows.last[start + n] = first[joint], last[joint]

    def _clear(self, own: Part, rows: Part, search: Part, base: int) -> None:
        own.sides[:], own.limits[:], own.near_since[:] = 0.0, -np.inf, np.inf
        own.carriers[:] = -1
        rows.A[:], rows.lower[:], rows.upper[:] = 0.0, -np.inf, np.inf
        rows.ends[:] = base, base + len(own.sides), len(rows.lower)
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
    supporting: np.ndarray, u: np.ndarray, costs: np.ndarray, without: np.ndarray,
    tau_max: np.ndarray, base: int, F: np.ndarray,
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
        bounds, rows, search, J, supporting, u, costs, without, wish, wish, 0.0, tau_max, base,
        0.0, F,
    )  # fmt: skip


class BoundedDistribution:
    """Distributes over given soles; build it once.

    With a `robot` what its motors have is kept, too; without one only the floor counts.
    Raises: `InputError` if a supporting contact is neither sole nor point.
    """

    def __init__(
        self,
        soles: Sequence[Contact],
        bounds: ReactionBounds | None = None,
        robot: Robot | None = None,
    ) -> None:
        self.soles = require_feet(soles)
        self.bounds = bounds or ReactionBounds()
        rows = sum(len(bounds_of(sole, self.bounds).b) for sole in self.soles)
        unknowns = sum(sole.size for sole in self.soles)
        self._tau_max = np.zeros(0) if robot is None else robot.tau_max
        self._base = BASE if robot is None else robot.nv_base
        self._program = BoundsProgram(self.bounds, unknowns, rows, len(self._tau_max))
        self._workspace = Workspace(self._program.shapes(), stages=[SOLVE])
        carriers = [] if robot is None else carriers_of(robot, self.soles)
        self._program.fill(self._workspace, self.soles, self._base, carriers)

    def __call__(
        self, u: Array, J: Array, lam_0: Array, costs: Array | None = None
    ) -> Distribution:
        """Return the distribution of the base rows of u over the rows of the soles.

        Args: `u` (6,) and `J` (k, 6) are those of the base, or with a robot (nv,) and (k, nv);
        `lam_0` (k,) is the reaction that would act with F = 0; `costs` (k,) > 0 of each component,
        by default those of equal loads.
        """
        if costs is None:
            costs = np.concatenate([sum(sole.reaction_costs()) for sole in self.soles])
        F, workspace = np.empty(len(lam_0)), self._workspace
        blocks = workspace.floats, workspace.integers, workspace.tables
        rows, without = np.ascontiguousarray(J, dtype=float), np.array(lam_0, dtype=float)
        whole, c = np.array(u, dtype=float), np.array(costs, dtype=float)
        supporting = np.arange(len(F))
        bounded_alone(*blocks, rows, supporting, whole, c, without, self._tau_max, self._base, F)
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


def carriers_of(robot: Robot, supports: Sequence[Contact]) -> list[tuple[int, ...]]:
    """Return for each support the joints between it and the base."""
    return [robot.joints_between(foot.frames[0]) for foot in require_feet(supports)]


def status_of(numbers: Array) -> DistributionStatus:
    """Return how the last distribution went, from the numbers of its part."""
    if numbers[STATUS] != SOLVED:
        return DistributionStatus.FAILED
    return DistributionStatus.SLACK if numbers[SLACK] > 1e-3 else DistributionStatus.POSSIBLE
