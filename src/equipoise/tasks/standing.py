"""How a task stands at a moment: met, at its bound, left over, or short; and by how much.

The viewer and `explain` ask here, so that both say the same word and the same number. "Short" is
a task that failed its user: more than `TOLERANCES` of its error are not worked off.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from equipoise.hqp import Explanation, Hierarchy, RowDescription, Shortfall
from equipoise.hqp.explain import TOLERANCE, sizes_of
from equipoise.hqp.explanation import AT_BOUND, LEFT_OVER, MET, SHORT, amounts_of, worst_of
from equipoise.hqp.solution import violation
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import Task
from equipoise.tasks.damping import DampingTask
from equipoise.tasks.posture import PostureTask

TOLERANCES = {"m": 1e-3, "rad": 1e-3}  # of an error that counts as none, by unit
OF_A_SPEED = 1e-3  # [unit/s] the same where no rate makes an error of a speed
ACTIVE = 1e-6  # share of a row's size within which it stands at its bound

Violations = Iterable[tuple[RowDescription, float]]


@dataclass(frozen=True)
class Standing:
    """`word` is MET, AT_BOUND, LEFT_OVER or SHORT; `amounts` by unit are what is not worked off.

    `where` names the worst row, if rows are called differently.
    """

    word: str
    amounts: tuple[tuple[float, str], ...] = ()
    where: str = ""


def standing_of(task: Task, kin: Kinematics, v: Array, t: float) -> Standing:
    """Return how a task stands with velocity `v` (nv,) at the state of `kin` and time `t` [s].

    Both are those of the reference, for which the rows were written.
    """
    rows = task.rows(kin, t)
    hierarchy = Hierarchy.stack([[rows]], len(v))
    if not len(hierarchy.lower):
        return Standing(MET)
    w, sizes = violation(hierarchy, v), sizes_of(hierarchy, v)
    words = task.describe(hierarchy.blocks[0], hierarchy)
    beyond = np.abs(w) > TOLERANCE * sizes
    if not beyond.any():
        inequality = hierarchy.lower < hierarchy.upper
        values = hierarchy.A @ v
        near = np.minimum(np.abs(values - hierarchy.lower), np.abs(hierarchy.upper - values))
        active = inequality & (near <= ACTIVE * np.maximum(sizes, 1e-3))
        return Standing(AT_BOUND if active.any() else MET)
    violated = tuple(zip(words, np.where(beyond, w, 0.0).tolist(), strict=True))
    word = word_of(task, violated)
    return Standing(word, amounts_of(violated), worst_of(violated))


def word_of(task: Task | None, rows: Violations) -> str:
    """Return what to call a task whose rows have these violations.

    What is left of the lowest wish, the posture or rest, failed nobody. Neither did a bound on
    speed that the task's own level had to pass, nor what is too small to be seen.
    """
    rows = tuple(rows)
    if isinstance(task, PostureTask | DampingTask):
        return LEFT_OVER
    if all(words.is_speed(w) for words, w in rows if w):
        return AT_BOUND
    small = all(value <= TOLERANCES.get(unit, OF_A_SPEED) for value, unit in amounts_of(rows))
    return AT_BOUND if small else SHORT


def with_standing(said: Explanation, tasks: Mapping[str, Task]) -> Explanation:
    """Return an explanation in which each shortfall has the word of its task."""

    def told(one: Shortfall) -> Shortfall:
        return replace(one, standing=word_of(tasks.get(one.task), one.rows))

    return replace(said, shortfalls=tuple(told(one) for one in said.shortfalls))
