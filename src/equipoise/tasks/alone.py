"""Calls the kernel of one task alone, outside of a tick."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from equipoise.compiled import entrance, specialised
from equipoise.compiled.workspace import part_of
from equipoise.tasks.view import TaskView


def alone_of(name: str, kernel: Callable[..., None]) -> Callable[..., None]:
    """Return an entrance that writes the rows of one task.

    Its workspace has the tree as part 0 and the state, with its centre of mass, as part 1.
    """
    return entrance(specialised(_alone, f"{name}_alone", rows_of=kernel))


def rows_of(view: TaskView) -> None:
    """Stand for the kernel in `_alone`."""
    raise NotImplementedError


def _alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, target: np.ndarray, rate: float,
    numbers: np.ndarray, A: np.ndarray, lower: np.ndarray, upper: np.ndarray,
) -> None:  # fmt: skip
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1)
    rows_of(TaskView(tree, state, 0, target, numbers[:0], rate, numbers, A, lower, upper, 0))
