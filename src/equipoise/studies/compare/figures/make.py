"""Which figures a study has results for, and how each is made: one list for pages and files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from equipoise.analysis.figures.style import new_figure, styled
from equipoise.studies.compare.figures import (
    causes,
    differences,
    effort,
    looks,
    maps,
    margins,
    success,
    survival,
    ticks,
)
from equipoise.studies.compare.tables import shown_metrics
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH = 6.4  # [inch] of a column


@dataclass(frozen=True)
class Panel:
    """One figure: its name, height [inch], and what draws it into axes."""

    name: str
    height: float
    draw: Callable[[Any], None]
    polar: bool = False


def panels(results: Results, baseline: str) -> list[Panel]:
    """Return the figures that a study has results for, in the order in which one reads them."""
    found: list[Panel] = []
    row = 0.55 * len(looks.looks_of(results))
    if success.can_draw(results):
        found.append(Panel("success", 1.3 + row, lambda a: success.draw(a, results, baseline)))
    for metric in shown_metrics(results):
        if differences.can_draw(results, baseline, metric):
            found.append(_difference(results, baseline, metric, row))
    for grid in maps.grids(results):
        found += [_map(results, grid, name) for name in results.controllers]
    for edge in maps.edges(results):
        found.append(_edge(results, edge))
    for name in survival.designs(results):
        found.append(_survival(results, name))
    for name in margins.designs(results):
        found.append(_margins(results, name))
    metric = next(iter(shown_metrics(results)), "")
    if metric and effort.can_draw(results, metric):
        found.append(Panel("effort", 3.6, lambda a: effort.draw(a, results, metric)))
    if causes.can_draw(results):
        found.append(Panel("causes", 2.0 + row, lambda a: causes.draw(a, results)))
    if ticks.can_draw(results):
        found.append(Panel("ticks", 1.1 + row, lambda a: ticks.draw(a, results)))
    return found


def _difference(results: Results, baseline: str, metric: str, row: float) -> Panel:
    draw = differences.draw
    return Panel(f"difference_{metric}", 1.2 + row, lambda a: draw(a, results, baseline, metric))


def _map(results: Results, grid: str, controller: str) -> Panel:
    def draw(axes: Any) -> None:
        maps.draw_map(axes, results, grid, controller)
        maps.legend(axes)

    return Panel(f"{grid}_{controller}", 4.0, draw)


def _edge(results: Results, design: str) -> Panel:
    return Panel(f"boundary_{design}", 4.0, lambda a: maps.draw_edges(a, results, design))


def _survival(results: Results, design: str) -> Panel:
    return Panel(f"survival_{design}", 3.4, lambda a: survival.draw(a, results, design))


def _margins(results: Results, design: str) -> Panel:
    return Panel(f"margins_{design}", 5.0, lambda a: margins.draw(a, results, design), polar=True)


@styled
def figure_of(panel: Panel) -> Figure:
    """Return a panel as a figure of its own."""
    figure = new_figure(WIDTH, panel.height)
    figure.set_layout_engine("constrained")
    panel.draw(figure.add_subplot(projection="polar" if panel.polar else None))
    return figure
