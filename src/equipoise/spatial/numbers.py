"""Numbers from outside, checked once where they enter."""

from __future__ import annotations

import math

import numpy as np

from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.spatial.se3 import Array


def real_array(
    name: str, values: object, shape: tuple[int, ...] | None, *, finite: bool = True
) -> Array:
    """Return numbers as a new array of floats of a given shape (None: of any).

    Raises: `InputError` if they are no real numbers, `ShapeError`; `NonFiniteError` for a NaN or an
    infinity unless these are allowed.
    """
    try:
        given = np.asarray(values)
    except (ValueError, TypeError) as error:  # rows of different lengths, for instance
        raise InputError(f"{name} must hold real numbers", given=type(values).__name__) from error
    if given.dtype.kind not in "fiu":
        raise InputError(
            f"{name} must hold real numbers", given=f"{type(values).__name__} of {given.dtype}"
        )
    if shape is not None and given.shape != shape:
        raise ShapeError(name, given.shape, shape)
    array = given.astype(float)
    if finite and not np.isfinite(array).all():
        raise NonFiniteError(f"{name} holds a NaN or an infinity", given=array.tolist())
    return array


def real_vector(name: str, values: object, size: int) -> Array:
    """Return a vector (size,) of finite numbers: see `real_array`."""
    return real_array(name, values, (size,))


def real_list(name: str, values: object, size: int) -> list[float]:
    """Return finite numbers as a list of floats: see `real_vector`, which is slower."""
    if type(values) is np.ndarray and values.dtype == np.float64 and values.shape == (size,):
        numbers: list[float] = values.tolist()
        if math.isfinite(sum(numbers)):  # a NaN or an infinity would be in the sum
            return numbers
    return real_vector(name, values, size).tolist()


def real_number(name: str, value: object, *, finite: bool = True) -> float:
    """Return a number as a float.

    Raises: `InputError` if it is none; `NonFiniteError` for a NaN or an infinity unless allowed.
    """
    if isinstance(value, np.ndarray) and value.shape == ():
        value = value[()]
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.number):
        raise InputError(f"{name} must be a real number", given=value)
    if isinstance(value, np.complexfloating):
        raise InputError(f"{name} must be a real number", given=value)
    try:
        number = float(value)
    except OverflowError:  # a whole number beyond all floats
        number = float("inf")
    if finite and not math.isfinite(number):
        raise NonFiniteError(f"{name} is not finite", given=number)
    return number


def time_of(t: object) -> float:
    """Return the time [s] of a tick as a float; quick where it is one already.

    Raises: `InputError` if it is no number, `NonFiniteError` if it is not finite.
    """
    return t if type(t) is float and math.isfinite(t) else real_number("the time", t)


def real_period(name: str, value: object) -> float:
    """Return a period [s], finite and positive. Raises: `InputError`."""
    period = real_number(name, value, finite=False)
    if not (math.isfinite(period) and period > 0.0):
        raise InputError(f"{name} must be finite and positive", given=value, remedy="Give seconds")
    return period


def positive(name: str, value: object, unit: str = "") -> float:
    """Return a finite number above zero. Raises: `InputError`."""
    number = _number(value)
    if not (np.isfinite(number) and number > 0.0):
        raise InputError(f"{name} must be finite and positive{_bracketed(unit)}", given=value)
    return number


def not_negative(name: str, value: object, unit: str = "") -> float:
    """Return a finite number that is zero or above. Raises: `InputError`."""
    number = _number(value)
    if not (np.isfinite(number) and number >= 0.0):
        raise InputError(f"{name} must be finite and not negative{_bracketed(unit)}", given=value)
    return number


def share(name: str, value: object) -> float:
    """Return a share, above zero and at most one. Raises: `InputError`."""
    number = _number(value)
    if not 0.0 < number <= 1.0:
        raise InputError(f"{name} must be in (0, 1]", given=value)
    return number


def require_period(dt: object) -> float:
    """Return a period [s] that is finite and positive. Raises: `InputError`."""
    return real_period("the period", dt)


def _number(value: object) -> float:
    """Return a real number as a float, NaN for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        return np.nan
    return float(value)


def _bracketed(unit: str) -> str:
    return f" [{unit}]" if unit else ""
