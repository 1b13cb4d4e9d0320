"""How all figures look: sizes, colours, and curves thin enough to draw."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

DPI = 150
POINTS = 2000
# Okabe and Ito's colours, which colour-blind people tell apart, without their yellow.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#4D4D4D", "#8B5A2B")
INK, SOFT, FAINT, ALARM = "#222222", "#6B6B6B", "#C9C9C9", "#B00020"

_RC = {
    "font.size": 10.0,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 10.0,
    "axes.labelcolor": INK,
    "axes.edgecolor": SOFT,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.7,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "lines.linewidth": 1.5,
    "figure.facecolor": "white",
    "axes.xmargin": 0.01,
}


def styled(draw: Callable) -> Callable:
    """Let a function that draws see the house style, and nobody else."""

    @wraps(draw)
    def wrapper(*args: object, **kwargs: object) -> object:
        from matplotlib import rc_context

        with rc_context(_RC):
            return draw(*args, **kwargs)

    return wrapper


def new_figure(width: float, height: float, title: str = "") -> Figure:
    """Return an empty figure of that size [inch] with a title at its upper left."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.08, h_pad=0.08, wspace=0.03, hspace=0.05)
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(title, x=0.01, ha="left", fontsize=13, fontweight="bold", color=INK)
    return figure


@styled
def save(figure: Figure, path: Path) -> Path:
    """Write the figure as PNG and return its path."""
    figure.savefig(path, dpi=DPI)
    return path


def draw_curve(axes: Axes, t: Array, y: Array, **look: object) -> Line2D:
    """Draw y (n,) over t (n,) [s], thinned so that every spike stays visible."""
    x, values = decimate(t, y)
    if len(x) <= 3:
        look.setdefault("marker", "o")
    look.setdefault("solid_joinstyle", "round")
    return axes.plot(x, values, **look)[0]


def curve_look(k: int, *, dashed: bool) -> dict[str, object]:
    """Return the look of the k-th curve; a dashed one shows what lies under it."""
    dashes = (0, (3, 2)) if dashed else "-"
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": dashes, "linewidth": 1.8}


def finite(values: Array) -> Array:
    """Return the values with zeros for those that are not finite."""
    return np.where(np.isfinite(values), values, 0.0)


def number(value: float, form: str) -> str:
    """Return a number as text, with a true minus sign."""
    return format(value, form).replace("-", "\N{MINUS SIGN}")


def decimate(t: Array, y: Array, points: int = POINTS) -> tuple[Array, Array]:
    """Return at most `points` samples of a curve, with the least and largest of every stretch.

    First and last sample stay. Values that are not finite become one NaN a stretch: a gap.
    """
    values = np.where(np.isfinite(y), y, np.nan)
    if len(t) <= points:
        return np.asarray(t), values
    size = -(-len(t) // max(1, (points - 2) // 3))
    count = -(-len(t) // size)
    stretches = np.full((count, size), np.nan)
    stretches.flat[: len(t)] = values
    missing = np.isnan(stretches)
    starts = size * np.arange(count)
    gaps = missing.any(axis=1)
    if len(t) % size:
        gaps[-1] = missing[-1, : len(t) % size].any()
    some = ~missing.all(axis=1)
    least = np.where(missing, np.inf, stretches).argmin(axis=1)
    largest = np.where(missing, -np.inf, stretches).argmax(axis=1)
    gap = (starts + missing.argmax(axis=1))[gaps]
    kept = ([0, len(t) - 1], gap, (starts + least)[some], (starts + largest)[some])
    index = np.unique(np.concatenate(kept))
    return np.asarray(t)[index], values[index]


def label_time(axes: Axes | Sequence[Axes], t: Array) -> None:
    """Write the time axis under axes and span it over the run."""
    for one in np.atleast_1d(axes):
        one.set_xlabel("time [s]")
        if len(t) > 1:
            one.set_xlim(float(t[0]), float(t[-1]))


def zero_line(axes: Axes) -> None:
    """Draw the line y = 0."""
    axes.axhline(0.0, color=SOFT, linewidth=0.9, zorder=1.5)


def legend_below(axes: Axes, letters: int) -> None:
    """Write the legend under the axes, in as many columns as fit into that many letters."""
    widest = max((len(label) for label in axes.get_legend_handles_labels()[1]), default=0)
    columns = max(1, letters // (widest + 5))
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, -0.2),
        ncols=columns,
        columnspacing=1.0,
        borderaxespad=0.0,
    )
