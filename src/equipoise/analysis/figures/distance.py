"""Figure of the distances of the monitored pairs, the closest ones by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.figures.layout import HANDLE, RIM, SIDE, Area, Row, axes_grid, text_width
from equipoise.analysis.figures.style import (
    ALARM,
    COLOURS,
    FAINT,
    INK,
    NamedLook,
    draw_curve,
    label_time,
    new_figure,
    styled,
)
from equipoise.analysis.run_context import RunContext
from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH = 13.3  # [inch]
_NAMED = 7
_SAME = 1e-3  # [m]


@dataclass(frozen=True)
class Curve:
    """Pairs whose distances stay within a millimetre of the first one's (N,) [m], drawn as one."""

    names: tuple[str, ...]
    distance: Array

    @property
    def least(self) -> float:
        """The smallest distance [m] of the first pair, infinite without any."""
        known = self.distance[np.isfinite(self.distance)]
        return float(known.min()) if known.size else np.inf

    @property
    def label(self) -> str:
        """The names of the pairs, without repeating the body they share."""
        if len(self.names) == 1:
            return self.names[0]
        firsts, seconds = zip(*(name.partition(" - ")[::2] for name in self.names), strict=True)
        if len(set(seconds)) == 1:
            return f"{', '.join(firsts)} - {seconds[0]}"
        if len(set(firsts)) == 1:
            return f"{firsts[0]} - {', '.join(seconds)}"
        return "; ".join(self.names)


def curves_of(names: tuple[str, ...], distances: Array) -> list[Curve]:
    """Return the curves of (N, k) distances, the one that comes closest first."""
    curves: list[Curve] = []
    known = np.where(np.isfinite(distances), distances, np.inf)
    for k in np.argsort(known.min(axis=0), kind="stable"):
        distance = distances[:, k]
        for i, curve in enumerate(curves):
            if _same(curve.distance, distance):
                curves[i] = Curve((*curve.names, names[k]), curve.distance)
                break
        else:
            curves.append(Curve((names[k],), distance))
    return curves


def _same(first: Array, second: Array) -> bool:
    with np.errstate(invalid="ignore"):
        return bool(np.abs(first - second).max() < _SAME)


@styled
def distances_figure(context: RunContext) -> Figure | None:
    """Draw the distances with the security distance; None where no pair was monitored."""
    if not context.has("distance"):
        return None
    t, distances = context.run.t, context.run["distance"]
    names = context.run.channels["distance"].labels
    curves = curves_of(names, distances)
    closest = curves[0]
    title = (
        f"Distances of the monitored pairs (smallest: {1e3 * closest.least:.3f} mm,"
        f" {closest.names[0]} at {t[int(np.argmax(closest.distance == closest.least))]:.2f} s)"
    )
    figure = new_figure(_WIDTH, 6.0, title)
    edge = figure.get_figwidth() - HANDLE - text_width([_label(curve) for curve in curves[:_NAMED]])
    axes = axes_grid(figure, Area(0.0, max(edge, 0.4 * _WIDTH)), [SIDE], [Row(RIM)])[0][0]
    for curve in curves[_NAMED:]:
        draw_curve(axes, t, 1e3 * curve.distance, color=FAINT, linewidth=0.8)
    for curve, colour in zip(curves[:_NAMED], COLOURS, strict=False):
        look: NamedLook = {"color": colour, "label": _label(curve), "linewidth": 1.8}
        draw_curve(axes, t, 1e3 * curve.distance, **look)
    if len(curves) > _NAMED:
        axes.plot([], [], color=FAINT, label=f"{len(curves) - _NAMED} others, farther away")
    _draw_security(axes, context, names)
    axes.set_ylim(*_range(curves[:_NAMED]))
    axes.set_ylabel("distance [mm]")
    label_time(axes, t)
    axes.legend(
        loc="upper left",
        bbox_to_anchor=(1.0, 1.0),
        title="pair (its smallest distance)",
        alignment="left",
        title_fontsize=9,
    )
    return figure


def _label(curve: Curve) -> str:
    return f"{curve.label}  ({1e3 * curve.least:.1f} mm)"


def _range(curves: list[Curve]) -> tuple[float, float]:
    """Return the range of the picture [mm]: where the named curves come close, not all of them."""
    least = [1e3 * curve.least for curve in curves]
    return min(0.0, 1.1 * least[0]), float(np.clip(4.0 * least[-1], 100.0, 400.0))


def _draw_security(axes: Axes, context: RunContext, names: tuple[str, ...]) -> None:
    wanted = sorted({d for pair, d in context.security.items() if pair in names})
    axes.axhline(0.0, color=INK, linewidth=0.9)
    for distance in wanted:
        label = f"security distance {1e3 * distance:g} mm"
        axes.axhline(1e3 * distance, color=ALARM, linewidth=1.3, linestyle="--", label=label)
    if wanted:
        axes.axhspan(0.0, 1e3 * wanted[0], color=ALARM, alpha=0.06, linewidth=0)
