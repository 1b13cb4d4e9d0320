"""Calls the kernels of one contact alone, outside of a tick."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from equipoise.compiled import entrance, specialised
from equipoise.compiled.workspace import part_of
from equipoise.contacts.view import ContactView


def alone_of(
    name: str, rows: Callable[..., None], drift: Callable[..., None]
) -> Callable[..., None]:
    """Return an entrance that writes rows and drift of one contact.

    Its workspace has the tree as part 0 and the state, with velocities, as part 1.
    """
    return entrance(specialised(_alone, f"{name}_alone", rows_of=rows, drift_of=drift))


def rows_of(view: ContactView) -> None:
    """Stand for the kernel of the rows in `_alone`."""
    raise NotImplementedError


def drift_of(view: ContactView) -> None:
    """Stand for the kernel of the drift in `_alone`."""
    raise NotImplementedError


def _alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, numbers: np.ndarray,
    place: np.ndarray, sample: np.ndarray, surface: int, J: np.ndarray, others: np.ndarray,
) -> None:  # fmt: skip
    view = ContactView(
        part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1), 0, 1, numbers, place,
        sample, surface, J, 0, others[0], others[1], others[2], 0,
    )  # fmt: skip
    rows_of(view)
    drift_of(view)
