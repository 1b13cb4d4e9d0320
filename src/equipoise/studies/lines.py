"""Lines on which a boundary is looked for: from where a run should be good to where it need not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from equipoise.studies.draw import (
    Values,
    between,
    combined,
    ends_of,
    nominal_values,
    unit_points,
    value_at,
)
from equipoise.studies.schema import BoundarySpec, ParameterSpec


@dataclass(frozen=True)
class Line:
    """From `begin` to `end`, values of some parameters; `rest` are those that stay.

    `name` says along what: a parameter with + or - for its direction, or `all`.
    """

    name: str
    begin: Mapping[str, float]
    end: Mapping[str, float]
    rest: Values

    def at(self, share: float, parameters: Mapping[str, ParameterSpec]) -> Values:
        """Return the values at a share in [0, 1] of the line."""
        moved = {
            name: between(parameters[name], self.begin[name], self.end[name], share)
            for name in self.begin
        }
        return {**self.rest, **moved}


def lines_of(parameters: Mapping[str, ParameterSpec], design: BoundarySpec) -> list[Line]:
    """Return the lines of a design, in the order in which its points are numbered."""
    if design.along == "all":
        return _rays(parameters, design)
    if design.along != "each":
        cells = combined(parameters, design.over) if design.over else [nominal_values(parameters)]
        return [line for rest in cells for line in _along(design.along, parameters, rest)]
    rest = nominal_values(parameters)
    ordered = [name for name, spec in parameters.items() if spec.choice is None]
    return [line for name in ordered for line in _along(name, parameters, rest)]


def _along(name: str, parameters: Mapping[str, ParameterSpec], rest: Values) -> list[Line]:
    """Return the lines of one parameter: up, down, or both if its nominal value is between."""
    low, high = ends_of(parameters[name])
    nominal = parameters[name].nominal
    start = low if nominal is None else min(max(nominal, low), high)
    still = {key: value for key, value in rest.items() if key != name}
    ends = [("+", high)] * (high > start) + [("-", low)] * (low < start)
    return [Line(f"{name}{sign}", {name: start}, {name: end}, still) for sign, end in ends]


def _rays(parameters: Mapping[str, ParameterSpec], design: BoundarySpec) -> list[Line]:
    """Return lines from nominal to Sobol points, through all parameters that have an order."""
    assert design.points is not None
    begin = {name: float(spec.nominal) for name, spec in parameters.items()
             if spec.choice is None and spec.nominal is not None}  # fmt: skip
    rest = {key: value for key, value in nominal_values(parameters).items() if key not in begin}
    ends = unit_points("sobol", len(begin), design.points, design.seed)
    return [
        Line(
            "all",
            begin,
            {n: float(value_at(parameters[n], float(u))) for n, u in zip(begin, row, strict=True)},
            rest,
        )
        for row in ends
    ]
