"""Where a study looks: values of its parameters from numbers in [0, 1], point by point."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
from scipy.stats import qmc

from equipoise.spatial import Array
from equipoise.studies.schema import (
    GridSpec,
    LatinHypercubeSpec,
    ParameterSpec,
    SobolSpec,
)

Values = dict[str, Any]


def value_at(spec: ParameterSpec, u: float) -> Any:
    """Return the value of a parameter at `u` in [0, 1] of its range, or of its list."""
    if spec.uniform is not None:
        low, high = spec.uniform
        return float(low + u * (high - low))
    if spec.log_uniform is not None:
        low, high = np.log(spec.log_uniform)
        return float(np.exp(low + u * (high - low)))
    items = list_of(spec)
    return items[min(int(u * len(items)), len(items) - 1)]


def list_of(spec: ParameterSpec) -> list[Any]:
    """Return the values of a parameter that has a list of them; empty for a range."""
    if spec.grid is not None:
        return list(spec.grid)
    return list(spec.choice or [])


def ends_of(spec: ParameterSpec) -> tuple[float, float]:
    """Return the least and the largest value of a parameter that has an order."""
    numbers = spec.uniform or spec.log_uniform or spec.grid or [0.0]
    return float(min(numbers)), float(max(numbers))


def between(spec: ParameterSpec, begin: float, end: float, share: float) -> float:
    """Return the value at a `share` of the way from one to another, by ratio where it is drawn so.

    Source: none; a geometric mean is the middle of a logarithmic range.
    """
    if share in (0.0, 1.0):
        return end if share else begin
    if spec.log_uniform is not None and begin > 0.0 and end > 0.0:
        return float(begin * (end / begin) ** share)
    return float(begin + share * (end - begin))


def nominal_values(parameters: Mapping[str, ParameterSpec]) -> Values:
    """Return the nominal values of those parameters that have one."""
    return {name: spec.nominal for name, spec in parameters.items() if spec.nominal is not None}


def sampled(
    parameters: Mapping[str, ParameterSpec], design: SobolSpec | LatinHypercubeSpec
) -> list[Values]:
    """Return the points of a design that fills the whole space."""
    unit = unit_points(design.kind, len(parameters), design.points, design.seed)
    return [
        {
            name: value_at(spec, float(u))
            for (name, spec), u in zip(parameters.items(), row, strict=True)
        }
        for row in unit
    ]


def unit_points(kind: str, dimensions: int, count: int, seed: int) -> Array:
    """Return points (count, dimensions) in the unit cube; the same seed gives the same ones.

    Source: scipy.stats.qmc, scrambled Sobol (Joe and Kuo's directions) or Latin hypercube.
    """
    rng = np.random.default_rng(seed)
    if kind == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=rng).random(count))
    power = max(int(np.ceil(np.log2(count))), 0)
    return np.asarray(qmc.Sobol(dimensions, rng=rng).random_base2(power))[:count]


def combined(parameters: Mapping[str, ParameterSpec], over: Mapping[str, int]) -> list[Values]:
    """Return every combination of values of the parameters `over`, the others nominal."""
    axes = {name: axis_of(parameters[name], count) for name, count in over.items()}
    rest = nominal_values(parameters)
    return [{**rest, **dict(zip(axes, values, strict=True))} for values in product(*axes.values())]


def axis_of(spec: ParameterSpec, count: int) -> list[Any]:
    """Return the values of one axis of a grid: of a range so many, both ends among them."""
    items = list_of(spec)
    if items:
        return items
    low, high = ends_of(spec)
    if count == 1:
        return [spec.nominal if spec.nominal is not None else low]
    return [between(spec, low, high, k / (count - 1)) for k in range(count)]


def points_of(
    parameters: Mapping[str, ParameterSpec], design: SobolSpec | LatinHypercubeSpec | GridSpec
) -> list[Values]:
    """Return the points of a design that is known before anything runs."""
    if isinstance(design, GridSpec):
        return combined(parameters, design.over)
    return sampled(parameters, design)
