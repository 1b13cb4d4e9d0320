"""Why a task is not met: which rows stand in its way, and how far each would have to give way.

Who blocks is read from the multipliers of the certificate: rows that carry none, neither on the
task's level nor on that of a blocker that is violated itself, can be taken away, and the task stays
as short as it is. How far they would have to give way is found by putting the
task first and solving again: what then breaks, least important rows first, is what it would cost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.errors import NameNotFoundError, NonFiniteError
from equipoise.hqp.certificate import certify
from equipoise.hqp.explanation import Blocker, Explanation, Shortfall
from equipoise.hqp.hierarchy import Block, Hierarchy
from equipoise.hqp.row_names import RowDescription, plain_descriptions
from equipoise.hqp.solution import violation
from equipoise.hqp.solvers import make_solver

TOLERANCE = 1e-6  # share of a row's size from which on a task counts as short
EXACT = 1e-9  # the same, from which on a bound counts as violated: small steps matter where rows
# are nearly dependent
MULTIPLIER_TOLERANCE = 1e-11  # share of the pull on a task below which a multiplier is none
OPTIMAL = 1e-5  # excess of a level, relative to its size, above which an answer is no optimum


def explain(
    hierarchy: Hierarchy,
    v: np.ndarray,
    words: Sequence[RowDescription] | None = None,
    *,
    tasks: Sequence[str] = (),
    tolerance: float = TOLERANCE,
) -> Explanation:
    """Say of every task (or of `tasks`, by name) that `v` [n] leaves short what blocks it.

    `words` [m] are how rows are called; by default the names in the hierarchy. A task counts as
    short if a row is violated by more than `tolerance` times the size of the row's value.

    Raises:
        NonFiniteError: `v` is not finite.
        NameNotFoundError: the hierarchy has no task of a name in `tasks`.
    """
    if not np.isfinite(v).all():
        raise NonFiniteError(
            "There is no answer to explain: v is not finite",
            given=int(np.count_nonzero(~np.isfinite(v))),
            remedy="Solve the hierarchy again, with the solver 'cascade' for example",
        )
    words = plain_descriptions(hierarchy) if words is None else tuple(words)
    known = {b.name for b in hierarchy.blocks}
    for name in tasks:
        if name not in known:
            raise NameNotFoundError("task", name, known)
    chosen = [b for b in hierarchy.blocks if not tasks or b.name in tasks]
    w = violation(hierarchy, v)
    sizes = sizes_of(hierarchy, v)
    short = [b for b in chosen if (np.abs(w[b.rows]) > tolerance * sizes[b.rows]).any()]
    if not short:
        return Explanation((), asked=tuple(tasks))
    limits = EXACT * sizes
    answer = _Answer(hierarchy, v, np.where(np.abs(w) > limits, w, 0.0), limits, words)
    certificate = certify(hierarchy, v)
    levels = [level.multipliers for level in certificate.levels]
    found = tuple(_shortfall(answer, block, levels) for block in short)
    return Explanation(found, certificate.holds(OPTIMAL), tuple(tasks))


def task_first(hierarchy: Hierarchy, block: Block) -> tuple[Hierarchy, np.ndarray]:
    """Return the hierarchy with one block moved to the top, and where its rows come from [k].

    Below it stand the levels above it in their order, then the rest of its own level; the levels
    below it are left out.
    """
    own = np.arange(block.rows.start, block.rows.stop)
    groups = [own]
    for i in range(block.level + 1):
        rows = np.arange(*hierarchy.level(i).indices(len(hierarchy.lower)))
        groups.append(np.setdiff1d(rows, own) if i == block.level else rows)
    order = np.concatenate(groups)
    ends = tuple(np.cumsum([len(group) for group in groups]).tolist())
    A, lower, upper = hierarchy.A[order], hierarchy.lower[order], hierarchy.upper[order]
    return Hierarchy(A, lower, upper, ends, ()), order


@dataclass(frozen=True, slots=True)
class _Answer:
    """A hierarchy with an answer: `w` [m] the violations that count, `limits` [m] what counts."""

    hierarchy: Hierarchy
    v: np.ndarray
    w: np.ndarray
    limits: np.ndarray
    words: tuple[RowDescription, ...]


def _multipliers(answer: _Answer, rows: slice, level: int, above: np.ndarray) -> np.ndarray:
    """Return what every row pulls at `rows` of a level with [m]: rows of that level with their w.

    `above` are the multipliers of the rows of the levels above.
    """
    h, w = answer.hierarchy, answer.w
    multipliers = np.zeros(len(w))
    multipliers[: len(above)] = above
    multipliers[h.level(level)] = w[h.level(level)]
    multipliers[rows] = 0.0
    pull = np.linalg.norm(h.A[rows].T @ w[rows])
    small = np.abs(multipliers) * np.linalg.norm(h.A, axis=1) <= MULTIPLIER_TOLERANCE * pull
    multipliers[small] = 0.0
    return multipliers


def _behind(answer: _Answer, blocking: np.ndarray, levels: list[np.ndarray]) -> np.ndarray:
    """Return the rows that hold violated blockers where they are, besides the blockers [k].

    `blocking` [m] tells the blockers.
    """
    h, reached = answer.hierarchy, blocking.copy()
    for i in reversed(range(len(h.ends))):
        level = h.level(i)
        if (reached[level] & (answer.w[level] != 0.0)).any():
            reached[level] |= answer.w[level] != 0.0
            reached |= _multipliers(answer, level, i, levels[i]) != 0.0
    return np.flatnonzero(reached & ~blocking)


def _shortfall(answer: _Answer, block: Block, levels: list[np.ndarray]) -> Shortfall:
    h, rows = answer.hierarchy, block.rows
    multipliers = _multipliers(answer, rows, block.level, levels[block.level])
    broken, change = _price(answer, block)
    alone = float(np.linalg.norm(broken[rows]))
    broken[rows] = 0.0
    work = np.where(broken != 0.0, np.maximum(multipliers * change, 0.0), 0.0)
    shares = work / work.sum() if work.any() else work
    blocking = (multipliers != 0.0) | (broken != 0.0)
    blockers = [
        Blocker(
            row=int(r),
            name=h.name_of(int(r)),
            level=h.block_of(int(r)).level,
            words=answer.words[r],
            multiplier=float(multipliers[r]),
            share=float(shares[r]),
            broken=float(broken[r]),
            short=float(answer.w[r]),
        )
        for r in np.flatnonzero(blocking)
    ]
    blockers.sort(key=lambda b: (-b.share, -abs(b.broken)))
    blocking[rows] = True
    own = zip(answer.words[rows], answer.w[rows].tolist(), strict=True)
    behind = tuple(_behind(answer, blocking, levels).tolist())
    return Shortfall(block.name, block.level, tuple(own), tuple(blockers), behind, alone)


def _price(answer: _Answer, block: Block) -> tuple[np.ndarray, np.ndarray]:
    """Return by how much each row is violated [m] if the block comes first, and how A v changes."""
    first, order = task_first(answer.hierarchy, block)
    v_met = _certified(first)
    broken, change = np.zeros((2, len(answer.w)))
    broken[order] = violation(first, v_met)
    change[order] = first.A @ (v_met - answer.v)
    broken[np.abs(broken) <= answer.limits] = 0.0
    return broken, change


def _certified(hierarchy: Hierarchy) -> np.ndarray:
    """Return the optimum [n] of the first exact solver whose answer the certificate confirms.

    The cascade needs no compiled code, so it is asked first.
    """
    answers = []
    for name in ("cascade", "active_set"):
        solution = make_solver(name).solve(hierarchy)
        if certify(hierarchy, solution.v).holds(OPTIMAL):
            return solution.v
        answers.append(solution)
    return min(answers, key=lambda answer: answer.slack).v


def sizes_of(hierarchy: Hierarchy, v: np.ndarray) -> np.ndarray:
    """Return the size of each row's value [m]: of A v if nothing cancelled, or of the bound."""
    values = np.linalg.norm(hierarchy.A, axis=1) * np.linalg.norm(v)
    return np.maximum(values, np.abs(np.clip(0.0, hierarchy.lower, hierarchy.upper)))
