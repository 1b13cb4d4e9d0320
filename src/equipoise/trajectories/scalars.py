"""The scalars of a tick, and the one place that calls their kernels.

A new kind of scalar is its file and a line in `evaluate_scalars`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from equipoise.compiled import compiled
from equipoise.compiled.workspace import Arrays, Block, Part, Shape, integers, vector
from equipoise.spatial import Array
from equipoise.trajectories.live_scalar import LiveScalar, live_scalar_at
from equipoise.trajectories.profile import profile_at
from equipoise.trajectories.pushing import pushing_at
from equipoise.trajectories.scalar import (
    GIVEN,
    LIVE,
    PROFILE,
    PUSHING,
    CompiledScalar,
    ScalarTrajectory,
)

SCALARS = Arrays(
    ("values", "offsets", "least", "numbers", "kind", "first"), frozenset({"kind", "first"})
)
VALUES, OFFSETS, LEAST, NUMBERS, KIND, FIRST = range(len(SCALARS.names))

Scalar = ScalarTrajectory | Callable[[float], float]


def numbers_of(scalar: Scalar) -> Array:
    """Return what the kernel of a scalar needs (k,)."""
    return scalar.numbers if isinstance(scalar, CompiledScalar) else np.zeros(0)


def kind_of(scalar: Scalar) -> int:
    """Return the kind of a scalar as kernels know it."""
    return scalar.kind if isinstance(scalar, ScalarTrajectory) else GIVEN


def value_of(scalar: Scalar, t: float) -> float:
    """Return a scalar at time `t` [s], an object or a plain function."""
    return float(scalar.at(t) if isinstance(scalar, ScalarTrajectory) else scalar(t))


def least_of(scalar: Scalar) -> float:
    """Return the least value of a scalar, as far as it is known; at time 0 otherwise."""
    least = scalar.least if isinstance(scalar, ScalarTrajectory) else None
    return value_of(scalar, 0.0) if least is None else least


def scalar_shapes(scalars: Sequence[Scalar]) -> list[tuple[str, Shape, bool]]:
    """Return the arrays: `values` [k], `offsets` [k] that a person adds, what kernels need.

    `least` [k] is the least that may be wanted of each: zero where a contact can only push.
    """
    count, pool = max(len(scalars), 1), sum(len(numbers_of(one)) for one in scalars)
    return SCALARS.shapes(
        values=count, offsets=count, least=count, numbers=max(pool, 1), kind=count, first=count + 1
    )


def fill_scalars(part: Part, scalars: Sequence[Scalar], least: Sequence[float]) -> None:
    """Write the constants; `least` [k] is the least that may be wanted of each."""
    part.least[: len(least)] = least
    start = 0
    for k, one in enumerate(scalars):
        numbers = numbers_of(one)
        part.kind[k], part.first[k] = kind_of(one), start
        part.numbers[start : start + len(numbers)] = numbers
        if isinstance(one, LiveScalar):
            one.work_in(part.numbers[start : start + len(numbers)])
        start += len(numbers)
        part.first[k + 1] = start


@compiled
def wanted_now(scalars: Block, k: int) -> float:
    """Return what is wanted of scalar k with what a person adds, no less than may be wanted."""
    value = vector(scalars, VALUES)[k] + vector(scalars, OFFSETS)[k]
    least = vector(scalars, LEAST)[k]
    return least if value < least else value  # so that a NaN stays one


@compiled
def evaluate_scalars(scalars: Block, t: float) -> None:
    """Write all values that kernels know at time t, offsets not yet added."""
    values, pool = vector(scalars, VALUES), vector(scalars, NUMBERS)
    kind, first = integers(scalars, KIND), integers(scalars, FIRST)
    for k in range(kind.shape[0]):
        numbers = pool[first[k] : first[k + 1]]
        if kind[k] == PROFILE:
            values[k] = profile_at(numbers, t)
        elif kind[k] == PUSHING:
            values[k] = pushing_at(numbers, t)
        elif kind[k] == LIVE:
            values[k] = live_scalar_at(numbers, t)
