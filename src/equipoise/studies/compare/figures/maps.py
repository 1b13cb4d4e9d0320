"""Two parameters: where a controller is good, and the boundaries that were bisected."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from equipoise.analysis.figures.style import INK
from equipoise.studies.compare.boundaries import brackets, value_on
from equipoise.studies.compare.figures.looks import looks_of
from equipoise.studies.compare.units import parameter_label
from equipoise.studies.results import Results
from equipoise.studies.schema import BoundarySpec, GridSpec

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FILLS = {"good": "#CFE5F2", "stands": "#F6D8A8", "falls": "#8C8C8C"}


def grids(results: Results) -> list[str]:
    """Return the designs that are grids over two parameters with an order."""
    parameters = results.study.parameters
    return [
        name
        for name, spec in results.study.designs.items()
        if isinstance(spec, GridSpec)
        and len(spec.over) == 2
        and all(parameters[one].choice is None for one in spec.over)
    ]


def edges(results: Results) -> list[str]:
    """Return the designs that are boundaries along one parameter over another."""
    return [
        name
        for name, spec in results.study.designs.items()
        if isinstance(spec, BoundarySpec) and len(spec.over) == 1
    ]


def draw_map(axes: Axes, results: Results, grid: str, controller: str) -> None:
    """Draw one controller's grid: good, standing, fallen; and its boundary over it."""
    spec = results.study.designs[grid]
    assert isinstance(spec, GridSpec)
    x_name, y_name = _axes_of(results, list(spec.over))
    rows = results.where(design=grid, controller=controller)
    x, y = results[f"p.{x_name}"][rows], results[f"p.{y_name}"][rows]
    xs, ys = np.unique(x), np.unique(y)
    shown = np.full((len(ys), len(xs)), np.nan)
    for i, value_y in enumerate(ys):
        for j, value_x in enumerate(xs):
            here = (x == value_x) & (y == value_y)
            good, stands = (results[what][rows][here].astype(bool) for what in ("good", "stands"))
            if len(good):
                shown[i, j] = 0 if good.all() else 1 if stands.all() else 2
    from matplotlib.colors import ListedColormap

    axes.pcolormesh(
        _edges(xs), _edges(ys), shown, cmap=ListedColormap(list(FILLS.values())), vmin=0, vmax=2,
        edgecolors="white", linewidth=0.8,
    )  # fmt: skip
    centres_x, centres_y = np.meshgrid(xs, ys)
    falls = shown == 2
    axes.plot(centres_x[falls], centres_y[falls], "x", color="white", markersize=4, mew=1.0)
    for edge in edges(results):
        draw_edge(axes, results, edge, controller, (x_name, y_name), color=INK)
    look = looks_of(results)[controller]
    axes.set_xlabel(parameter_label(results.study, x_name))
    axes.set_ylabel(parameter_label(results.study, y_name))
    axes.set_title(look.title)
    axes.grid(visible=False)


def draw_edge(
    axes: Axes,
    results: Results,
    design: str,
    controller: str,
    names: tuple[str, str],
    **look: Any,
) -> None:
    """Draw the boundary of a controller as a line, if it is one of these two parameters."""
    spec = results.study.designs[design]
    assert isinstance(spec, BoundarySpec)
    if {spec.along, *spec.over} != set(names):
        return
    (over,) = spec.over
    found = [b for b in brackets(results, design) if b.controller == controller]
    for sign in dict.fromkeys(b.line.name[-1] for b in found):
        mine = [b for b in found if b.line.name[-1] == sign]
        along = [value_on(results, b, b.middle, spec.along) for b in mine]
        across = [value_on(results, b, 0.0, over) for b in mine]
        x, y = (along, across) if names[0] == spec.along else (across, along)
        axes.plot(x, y, **{"linewidth": 2.0, "marker": "o", "markersize": 3.5, **look})


def draw_edges(axes: Axes, results: Results, design: str) -> None:
    """Draw the boundaries of all controllers into one map."""
    spec = results.study.designs[design]
    assert isinstance(spec, BoundarySpec)
    names = _axes_of(results, [spec.along, *spec.over])
    for name, look in looks_of(results).items():
        draw_edge(
            axes, results, design, name, names, color=look.colour, linestyle=look.dashes,
            marker=look.marker, label=look.title,
        )  # fmt: skip
    for axis, parameter in zip("xy", names, strict=True):
        low, high = _range(results, parameter)
        pad = 0.03 * (high - low)
        getattr(axes, f"set_{axis}lim")(low - pad, high + pad)
        getattr(axes, f"set_{axis}label")(parameter_label(results.study, parameter))
    handles, labels = axes.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    axes.legend(unique.values(), unique.keys(), loc="best")
    axes.set_title("Boundary of what is good")


def legend(axes: Axes) -> None:
    """Explain the colours of the maps."""
    from matplotlib.patches import Patch

    patches = [Patch(facecolor=colour, label=name) for name, colour in FILLS.items()]
    axes.legend(handles=patches, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3)


def _axes_of(results: Results, names: list[str]) -> tuple[str, str]:
    """Return which parameter goes along x and which along y: as the study lists them."""
    first, second = (name for name in results.study.parameters if name in names)
    return first, second


def _range(results: Results, parameter: str) -> tuple[float, float]:
    from equipoise.studies.draw import ends_of

    return ends_of(results.study.parameters[parameter])


def _edges(centres: np.ndarray) -> np.ndarray:
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middles = 0.5 * (centres[1:] + centres[:-1])
    first, last = centres[0] - (middles[0] - centres[0]), centres[-1] + (centres[-1] - middles[-1])
    return np.concatenate(([first], middles, [last]))
