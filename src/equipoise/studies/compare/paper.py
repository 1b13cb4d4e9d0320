"""One A4 page like that of a paper: what was run, two tables, the figures that say most."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from equipoise.analysis.figures.style import INK, new_figure, styled
from equipoise.studies.compare.figures.make import Panel, panels
from equipoise.studies.compare.tables import Table, against, success
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

A4 = (8.27, 11.69)
TALLEST = 6  # panels on a page
FIRST = ("success", "difference", "survival", "margins", "boundary", "effort", "causes")
EDGE = 0.07  # of the page, left and right


@styled
def paper_page(results: Results, baseline: str, setting: str) -> Figure:
    """Return the page."""
    from matplotlib import rc_context

    with rc_context({"font.size": 7.5, "axes.labelsize": 7.5, "axes.titlesize": 8.5,
                     "xtick.labelsize": 7.0, "ytick.labelsize": 7.0, "legend.fontsize": 6.5,
                     "lines.linewidth": 1.1}):  # fmt: skip
        figure = new_figure(*A4)
        study = results.study
        figure.text(EDGE, 0.965, study.title or study.name, fontsize=13, weight="bold", color=INK)
        text = textwrap.fill(setting, 125)
        figure.text(EDGE, 0.955, text, fontsize=8, va="top", color=INK)
        top = 0.945 - 0.013 * (1 + text.count("\n"))
        for table in (success(results), against(results, baseline)):
            if table.rows:
                top = _table(figure, table, top)
        _figures(figure, results, _chosen(panels(results, baseline)), top - 0.03)
        return figure


def _chosen(found: list[Panel]) -> list[Panel]:
    """Return the panels that say most, one of each kind before the second of any."""
    order = []
    for kind in FIRST:
        order += [panel for panel in found if panel.name.startswith(kind)][:1]
    order += [panel for panel in found if panel not in order]
    chosen = order[:TALLEST]
    return [panel for panel in found if panel in chosen]


def _table(figure: Figure, table: Table, top: float) -> float:
    """Draw a table below `top`, share of the page; return where it ends."""
    from matplotlib.transforms import Bbox

    line = 0.0145
    height = line * (len(table.rows) + 1)
    figure.text(EDGE, top - line, table.title, fontsize=8.5, weight="bold", color=INK)
    axes = figure.add_axes((EDGE, top - 1.5 * line - height, 1.0 - 2.0 * EDGE, height))
    axes.axis("off")
    cells = axes.table(
        cellText=[list(row) for row in table.rows],
        colLabels=[textwrap.shorten(column, 40) for column in table.columns],
        loc="upper center",
        cellLoc="right",
        edges="horizontal",
        bbox=Bbox.unit(),
    )
    cells.auto_set_font_size(False)
    cells.set_fontsize(7)
    cells.auto_set_column_width(list(range(len(table.columns))))
    for cell in cells.get_celld().values():
        cell.set_linewidth(0.5)
    for row in range(len(table.rows) + 1):
        cells[row, 0].set_text_props(ha="left")
    end = top - 1.6 * line - height
    if table.note:
        figure.text(EDGE, end - 0.003, table.note, fontsize=6.5, va="top", color=INK)
        end -= 0.014
    return end


def _figures(figure: Figure, results: Results, chosen: list[Panel], top: float) -> None:
    """Draw the panels in two columns below `top`."""
    if not chosen:
        return
    rows = -(-len(chosen) // 2)
    grid = figure.add_gridspec(
        rows, 2, left=0.16, right=0.96, top=top, bottom=0.07, hspace=0.5, wspace=0.5
    )
    for k, panel in enumerate(chosen):
        place = grid[k // 2, k % 2]
        axes = figure.add_subplot(place, projection="polar" if panel.polar else None)
        panel.draw(axes)
