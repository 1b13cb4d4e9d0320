"""How all figures look: sizes, colours, and curves thin enough to draw."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, ParamSpec, TypedDict, TypeVar, Unpack

import numpy as np

from equipoise.optional import require_package
from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.typing import ColorType, LineStyleType, RcKeyType

DPI = 150
POINTS = 2000
# Okabe and Ito's colours, which colour-blind people tell apart, without their yellow.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#4D4D4D", "#8B5A2B")
INK, SOFT, FAINT, ALARM = "#222222", "#6B6B6B", "#C9C9C9", "#B00020"

_RC: dict[RcKeyType, float | str | bool] = {
    "text.parse_math": False,  # a $ in a name or title is a $
    "font.size": 10.0,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # else every axis is measured once more to find it
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

P = ParamSpec("P")
R = TypeVar("R")


class Look(TypedDict, total=False):
    """How a curve is drawn, in matplotlib's words."""

    color: ColorType
    linestyle: LineStyleType
    linewidth: float
    marker: str
    alpha: float
    solid_joinstyle: str


class NamedLook(Look, total=False):
    """How a curve is drawn, and what the legend calls it."""

    label: str


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Let a function that draws see the house style, and nobody else."""

    @wraps(draw)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> R:
        require_package("matplotlib", "plot", "a figure")
        from matplotlib import rc_context

        with rc_context(_RC):
            return draw(*args, **kwargs)

    return wrapper


def new_figure(width: float, height: float, title: str = "") -> Figure:
    """Return an empty figure of that size [inch] with a title at its upper left."""
    require_package("matplotlib", "plot", "a figure")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    if title:
        look = {"fontsize": 13, "fontweight": "bold", "color": INK}
        figure.suptitle(title, x=0.01, y=1.0 - 0.1 / height, ha="left", va="top", **look)
    return figure


@styled
def save(figure: Figure, path: Path) -> Path:
    """Write the figure and return its path: as PNG without transparency, or as its ending says."""
    if path.suffix != ".png":
        figure.savefig(path, dpi=DPI)
        return path
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    canvas.draw()
    picture = Image.frombuffer("RGBA", canvas.get_width_height(), canvas.buffer_rgba())
    picture.convert("RGB").save(path, dpi=(DPI, DPI), compress_level=3)
    return path


def draw_curve(axes: Axes, t: Array, y: Array, **look: Unpack[NamedLook]) -> Line2D:
    """Draw y (n,) over t (n,) [s], thinned so that every spike stays visible."""
    x, values = decimate(t, y)
    if len(x) <= 3:
        look.setdefault("marker", "o")
    look.setdefault("solid_joinstyle", "round")
    return axes.plot(x, values, **look)[0]


def draw_together(axes: Axes, t: Array, columns: Array, **look: Unpack[NamedLook]) -> None:
    """Draw curves (n, k) that look alike as one line with gaps, which costs as little as one."""
    parts = [decimate(t, column) for column in columns.T]
    if not parts:
        return
    x = np.concatenate([np.append(x, np.nan) for x, _ in parts])
    values = np.concatenate([np.append(values, np.nan) for _, values in parts])
    look.setdefault("solid_joinstyle", "round")
    axes.plot(x, values, **look)


def curve_look(k: int, *, dashed: bool) -> Look:
    """Return the look of the k-th curve; a dashed one shows what lies under it."""
    dashes: LineStyleType = (0, (3, 2)) if dashed else "-"
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


def label_time(axes: Axes, t: Array) -> None:
    """Write the time axis under axes and span it over the run."""
    axes.set_xlabel("time [s]")
    if len(t) > 1:
        axes.set_xlim(float(t[0]), float(t[-1]))


def zero_line(axes: Axes) -> None:
    """Draw the line y = 0."""
    axes.axhline(0.0, color=SOFT, linewidth=0.9, zorder=1.5)
