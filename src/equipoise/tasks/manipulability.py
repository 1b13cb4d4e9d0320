"""A frame stays where its joints can move it well: manipulability above a least value, one row."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from equipoise.compiled import compiled, scratch, scratch_matrix
from equipoise.compiled.workspace import integers, matrix
from equipoise.errors import InputError, NameNotFoundError
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import COLUMNS, FRAMES
from equipoise.kinematics.tree import (
    FIRST_COLUMN,
    FIRST_V,
    FRAME_JOINT,
    FREE,
    KIND,
    PARENT,
    PLANAR,
)
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.kernels import crossed
from equipoise.spatial.numbers import positive
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask, require_frame, require_rate
from equipoise.tasks.view import MANIPULABILITY, TaskView

PARTS = {"position": (0, 3), "rotation": (3, 6), "both": (0, 6)}  # rows of the Jacobian
SINGULAR = 1e-12  # of the largest pivot: below it there is no gradient


@compiled
def manipulability_rows(task: TaskView) -> None:
    """Write `d/dt log m >= rate (log least - log m)`, nothing where m is zero.

    With m^2 = det(J J^T) and Y = (J J^T)^-1 J, d log m = sum over the columns of dJ . Y. What a
    joint i does to the column of a joint j (velocity v, angular velocity w of the frame): if i
    comes first or is j, both turn by w_i; else v_j changes by w_j x v_i. Followers have columns of
    their own here, and give to their leader's velocity.
    """
    tree, A, at = task.tree, task.A, task.at
    first_row, last_row = int(task.numbers[0]), int(task.numbers[1])
    columns, T = matrix(task.state, COLUMNS), matrix(task.state, FRAMES)[task.frame]
    parent, kind = integers(tree, PARENT), integers(tree, KIND)
    first_v, first = integers(tree, FIRST_V), integers(tree, FIRST_COLUMN)
    n, k = 0, last_row - first_row
    joint = integers(tree, FRAME_JOINT)[task.frame]
    while joint > 0 and kind[joint] != FREE and kind[joint] != PLANAR:
        n, joint = n + 1, parent[joint]
    J, V, Y = scratch_matrix(n, 6), scratch(n), scratch_matrix(n, 6)
    S, L = scratch_matrix(n, 6), scratch_matrix(6, 6)
    joint = integers(tree, FRAME_JOINT)[task.frame]
    for a in range(n - 1, -1, -1):  # own columns, from the base on
        c = columns[first[joint]]
        x, y, z = crossed(c[3], c[4], c[5], T[9], T[10], T[11])
        J[a, 0], J[a, 1], J[a, 2] = c[0] + x, c[1] + y, c[2] + z
        J[a, 3], J[a, 4], J[a, 5] = c[3], c[4], c[5]
        V[a] = first_v[joint]
        joint = parent[joint]
    for a in range(n):  # columns of the velocities: those of one velocity together, in each place
        for i in range(6):
            S[a, i] = 0.0
        for b in range(n):
            if V[b] == V[a]:
                for i in range(6):
                    S[a, i] += J[b, i]
        A[at, int(V[a])] = 0.0
    log_m = invert_gram(S, V, first_row, k, L, Y)
    task.upper[at] = np.inf
    if log_m == -np.inf:
        task.lower[at] = -np.inf
        return
    task.lower[at] = task.rate * (task.numbers[2] - log_m)
    for i in range(n):
        gradient = 0.0
        for j in range(n):
            if i <= j:
                x, y, z = crossed(J[i, 3], J[i, 4], J[i, 5], J[j, 0], J[j, 1], J[j, 2])
                u, r, s = crossed(J[i, 3], J[i, 4], J[i, 5], J[j, 3], J[j, 4], J[j, 5])
            else:
                x, y, z = crossed(J[j, 3], J[j, 4], J[j, 5], J[i, 0], J[i, 1], J[i, 2])
                u, r, s = 0.0, 0.0, 0.0
            gradient += x * Y[j, 0] + y * Y[j, 1] + z * Y[j, 2]
            gradient += u * Y[j, 3] + r * Y[j, 4] + s * Y[j, 5]
        A[at, int(V[i])] += gradient


@compiled
def invert_gram(
    S: np.ndarray, V: np.ndarray, first: int, k: int, L: np.ndarray, Y: np.ndarray
) -> float:
    """Write Y [n, 6], rows of `(J J^T)^-1 J` for k rows from `first` on, else zero; return log m.

    S [n, 6] are the columns of the velocities V [n]; one that occurs again counts once. It is
    minus infinity where J J^T has no inverse.
    """
    n, largest, log_m = S.shape[0], 0.0, 0.0
    for i in range(k):
        for j in range(i + 1):
            total = 0.0
            for a in range(n):
                counts = True
                for b in range(a):
                    if V[b] == V[a]:
                        counts = False
                if counts:
                    total += S[a, first + i] * S[a, first + j]
            for m in range(j):
                total -= L[i, m] * L[j, m]
            if i == j:
                largest = max(largest, total)
                if not total > SINGULAR * largest or largest <= 0.0:
                    return -np.inf
                L[i, i] = math.sqrt(total)
                log_m += math.log(L[i, i])
            else:
                L[i, j] = total / L[j, j]
    for a in range(n):
        for i in range(6):
            Y[a, i] = 0.0
        for i in range(k):
            total = S[a, first + i]
            for m in range(i):
                total -= L[i, m] * Y[a, first + m]
            Y[a, first + i] = total / L[i, i]
        for i in range(k - 1, -1, -1):
            total = Y[a, first + i]
            for m in range(i + 1, k):
                total -= L[m, i] * Y[a, first + m]
            Y[a, first + i] = total / L[i, i]
    return log_m


class ManipulabilityTask(KernelTask):
    """Keep the manipulability of a frame at `least`, or bring it there: one inequality row.

    It is `m = sqrt(det(J J^T))` of the rows that `part` says: "position", "rotation" or "both", by
    the joints between the base and the frame. The row is `d/dt log m >= rate (log least - log m)`:
    a large `least` at a low priority leads to where the joints move the frame best. In a posture
    that is singular there is no gradient, and the row is free.
    Source: Yoshikawa 1985; the gradient by the derivative of a determinant.
    Raises: `InputError` for a frame that fewer joints move than there are rows;
    `NameNotFoundError`.
    """

    row_unit = "1/s"
    kind = MANIPULABILITY
    alone = staticmethod(alone_of("manipulability", manipulability_rows))

    def __init__(
        self,
        name: str,
        robot: Robot,
        frame: str | int,
        least: float,
        *,
        part: Literal["position", "rotation", "both"] = "position",
        rate: float = 5.0,
    ) -> None:
        super().__init__(name)
        self.frame: str | int = require_frame(name, frame)
        if part not in PARTS:
            raise NameNotFoundError(f"part of task {name!r}", part, PARTS)
        self.part, self.rate = part, require_rate(name, rate)
        self.least = positive(f"the least value of task {name!r}", least, "")
        self._columns = [robot.nv_base + k for k in robot.joints_between(self.frame)]
        rows = PARTS[part][1] - PARTS[part][0]
        if len(self._columns) < rows:
            raise InputError(
                f"task {name!r}: {len(self._columns)} joints move this frame, which cannot give it "
                f"{rows} velocities of their own",
                given=frame,
                remedy='Name a frame further out, or take part="position"',
            )

    @property
    def labels(self) -> tuple[str, ...]:
        """One row."""
        return ("log",)

    @property
    def units(self) -> tuple[str, ...]:
        """A logarithm has none."""
        return ("",)

    @property
    def numbers(self) -> Array:
        """First and last row of the Jacobian, and the logarithm of the least value."""
        return np.array([*PARTS[self.part], math.log(self.least)])

    def value(self, kin: Kinematics) -> float:
        """Return the manipulability m."""
        J = kin.jacobian(self.frame)[slice(*PARTS[self.part]), self._columns]
        return math.sqrt(max(float(np.linalg.det(J @ J.T)), 0.0))

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return by how much the logarithm is below that of the least value (1,)."""
        value = self.value(kin)
        short = math.log(self.least / value) if value > 0.0 else math.inf
        return np.array([max(0.0, short)])

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls the row."""
        return (RowDescription.both(f"the manipulability of {self.frame}", "1/s", self.rate),)
