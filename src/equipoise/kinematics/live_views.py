"""Arrays that look into Pinocchio's and Coal's results, so that kernels read them without a copy.

Reading one placement or one distance through Python costs a microsecond and more; a tick reads
a hundred. Both libraries keep such results in one contiguous vector of plain numbers, which an
array with the right strides shows. The layout is checked whenever a view is made, against values
read the ordinary way, so that another version cannot be misread in silence.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from equipoise.errors import EquipoiseError
from equipoise.spatial import Array


class LayoutError(EquipoiseError):
    """A library keeps its results in another layout than the one this version knows."""


def pose_rows(placements: Sequence[Any]) -> Array:
    """Return a live view [k, 12] of a vector of SE3: rotation by columns, then translation."""

    def ordinary(T: Any) -> Array:
        return np.concatenate((T.rotation.T.ravel(), T.translation))

    return _view(placements, lambda T: T.rotation, 12, ordinary)


def motion_rows(motions: Sequence[Any]) -> Array:
    """Return a live view [k, 6] of a vector of spatial motions: linear, then angular."""
    return _view(motions, lambda motion: motion.linear, 6, lambda motion: motion.vector)


def distance_rows(results: Sequence[Any]) -> Array:
    """Return a live view [k, 10] of Coal's distance results.

    Each row holds distance [m], normal (3) and the two nearest points (3 each), world axes.
    """

    def ordinary(result: Any) -> Array:
        return np.concatenate(
            (
                [result.min_distance],
                result.normal,
                result.getNearestPoint1(),
                result.getNearestPoint2(),
            )
        )

    return _view(results, lambda result: result.normal, 10, ordinary, before=8)


def _view(
    vector: Sequence[Any],
    first_of: Callable[[Any], Array],
    width: int,
    ordinary: Callable[[Any], Array],
    before: int = 0,
) -> Array:
    """Return the view whose row begins `before` bytes ahead of the array `first_of(element)`."""
    count = len(vector)
    if count == 0:
        return np.zeros((0, width))
    starts = [first_of(vector[i]).ctypes.data - before for i in range(count)]
    stride = starts[1] - starts[0] if count > 1 else 8 * width
    if any(start != starts[0] + i * stride for i, start in enumerate(starts)):
        raise LayoutError(f"{type(vector).__name__} is not contiguous")
    holder = _Memory(starts[0], (count, width), (stride, 8), vector)
    view = np.asarray(holder)
    for i in range(count):
        if not np.array_equal(view[i], ordinary(vector[i]), equal_nan=True):
            raise LayoutError(f"{type(vector).__name__} holds its numbers in another order")
    return view


class _Memory:
    """The buffer of someone else, kept alive as long as an array looks into it."""

    def __init__(
        self, address: int, shape: tuple[int, int], strides: tuple[int, int], owner: Any
    ) -> None:
        self._owner = owner
        self.__array_interface__ = {
            "version": 3,
            "typestr": "<f8",
            "shape": shape,
            "strides": strides,
            "data": (address, False),  # kernels are compiled for writable arrays only
        }
