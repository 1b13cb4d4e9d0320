"""Numbers from outside, checked once where they enter."""

from __future__ import annotations

import numpy as np

from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.spatial.se3 import Array


def real_array(name: str, values: object, shape: tuple[int, ...], *, finite: bool = True) -> Array:
    """Return numbers as a new array of floats of a given shape.

    Raises: `InputError` if they are no real numbers, `ShapeError`; `NonFiniteError` for a NaN or an
    infinity unless these are allowed.
    """
    given = np.asarray(values)
    if given.dtype.kind not in "fiu":
        raise InputError(
            f"{name} must hold real numbers", given=f"{type(values).__name__} of {given.dtype}"
        )
    if given.shape != shape:
        raise ShapeError(name, given.shape, shape)
    array = given.astype(float)
    if finite and not np.isfinite(array).all():
        raise NonFiniteError(f"{name} holds a NaN or an infinity", given=array.tolist())
    return array


def real_vector(name: str, values: object, size: int) -> Array:
    """Return a vector (size,) of finite numbers: see `real_array`."""
    return real_array(name, values, (size,))
