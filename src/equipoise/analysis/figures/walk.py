"""Figure of a walk: zero-moment point, divergent component and centre of mass; phases and loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.feet_phases import PHASE
from equipoise.analysis.figures.layout import (
    NAMED,
    RIM,
    SIDE,
    Area,
    Row,
    axes_grid,
    whole,
)
from equipoise.analysis.figures.style import (
    COLOURS,
    FAINT,
    INK,
    SOFT,
    draw_curve,
    label_time,
    new_figure,
    styled,
)
from equipoise.analysis.run_context import RunContext
from equipoise.contacts import Phase
from equipoise.contacts.support_polygon import sole_corners
from equipoise.spatial import Array
from equipoise.walking import Feet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# colours of phases that nobody planned
UNPLANNED = {Phase.TOUCHED: COLOURS[4], Phase.LATE: COLOURS[3], Phase.LOST: INK}
SETTLED = 100  # ticks behind a touchdown at which a sole stands
_BALANCE = ("walk/dcm_error", "walk/zmp_shift")
_CHANNELS = ("walk/centre", "walk/zmp", "walk/dcm", "walk/carries", "com")


@styled
def walk_figure(context: RunContext) -> Figure | None:
    """Draw a walk from above and over time; None for a run that does not walk."""
    if not context.has(*_CHANNELS):
        return None
    figure = new_figure(13.3, 7.2, "The walk, wanted and achieved")
    area = whole(figure)
    left = Area(area.left, 0.465 * area.right)
    right = Area(0.465 * area.right, area.right)
    _draw_from_above(axes_grid(figure, left, [SIDE], [Row(below=NAMED)])[0][0], context)
    balanced = context.has(*_BALANCE)
    rows = [Row(below=RIM)] * (4 if balanced else 3) + [Row(below=NAMED)]
    column = [row[0] for row in axes_grid(figure, right, [SIDE], rows)]
    _draw_over_time(column[0], context, 0, "forward [m]")
    _draw_over_time(column[1], context, 1, "to the left [m]")
    _draw_loads(column[2], context)
    if balanced:
        _draw_balance(column[3], context)
    _draw_phases(column[-1], context)
    for axes in column:
        label_time(axes, context.run.t)
    for axes in column[:-1]:
        axes.set_xlabel("")
        axes.tick_params(labelbottom=False)
    column[2].legend(loc="center left", frameon=True, framealpha=0.85, edgecolor="none")
    return figure


def _curves(context: RunContext) -> tuple[tuple[str, Array, str], ...]:
    """Return name, values (N, 2 or 3) and colour of what is drawn over the ground."""
    run = context.run
    return (
        ("zero-moment point", run["walk/zmp"], COLOURS[1]),
        ("divergent component", run["walk/dcm"], COLOURS[2]),
        ("centre of mass, wanted", run["walk/centre"], COLOURS[0]),
        ("centre of mass", run["com"], INK),
    )


def _draw_from_above(axes: Axes, context: RunContext) -> None:
    for name, values, colour in _curves(context):
        dashed = name == "centre of mass"
        axes.plot(
            values[:, 0], values[:, 1], "--" if dashed else "-", color=colour, linewidth=1.2,
            label=name,
        )  # fmt: skip
    if context.known:
        _draw_footprints(axes, context)
    axes.legend(loc="upper left")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def _draw_footprints(axes: Axes, context: RunContext) -> None:
    """Draw where the soles stand: at the start, and where each is behind its touchdown."""
    run, robot = context.run, context.setup.robot
    for row, sole in enumerate(Feet.of(robot).soles):
        landed = np.flatnonzero(np.diff(run["walk/carries"][:, row]) > 0.0) + SETTLED
        for k in (0, *landed.tolist()):
            T = robot.at(run["q"][min(k, len(run.t) - 1)]).placement(sole.frame)
            corners = sole_corners(sole, T)[[0, 1, 2, 3, 0]]
            axes.plot(corners[:, 0], corners[:, 1], color=COLOURS[row], linewidth=0.8)


def _draw_over_time(axes: Axes, context: RunContext, column: int, name: str) -> None:
    for label, values, colour in _curves(context):
        y = values[:, column]
        if label == "centre of mass":
            draw_curve(axes, context.run.t, y, color=colour, linestyle="--", label=label)
        else:
            draw_curve(axes, context.run.t, y, color=colour, linestyle="-", label=label)
    axes.set_ylabel(name)


def _draw_balance(axes: Axes, context: RunContext) -> None:
    """Draw how far the divergent component is from its plan, and what leads it back."""
    run = context.run
    for k, (channel, name) in enumerate(zip(_BALANCE, ("error", "correction"), strict=True)):
        x, y = 1e3 * run[channel].T
        draw_curve(axes, run.t, x, color=COLOURS[k], linestyle="-", label=f"{name}, forward")
        draw_curve(axes, run.t, y, color=COLOURS[k], linestyle="--", label=f"{name}, left")
    axes.set_ylabel("DCM [mm]")
    axes.legend(loc="upper right", ncols=2)


def _draw_loads(axes: Axes, context: RunContext) -> None:
    run = context.run
    soles = [name.removeprefix("margin/") for name in run.names if name.startswith("margin/")]
    for k, sole in enumerate(soles):
        load = run[f"lam/{sole}"][:, 2]
        draw_curve(axes, run.t, load, color=COLOURS[k], linestyle="-", label=sole)
    axes.set_ylabel("load [N]")


def _draw_phases(axes: Axes, context: RunContext) -> None:
    """Draw when each foot carries, as bars, and inside them what nobody planned of it."""
    t, carries = context.run.t, context.run["walk/carries"]
    axes.set_yticks([])
    axes.set_ylim(-0.5, 1.7)
    for row, name in enumerate(("left", "right")):
        on = np.concatenate(([0.0], carries[:, row], [0.0]))
        starts, ends = np.flatnonzero(np.diff(on) > 0.0), np.flatnonzero(np.diff(on) < 0.0) - 1
        bars = [(t[a], t[b] - t[a]) for a, b in zip(starts, ends, strict=True)]
        axes.broken_barh(bars, (row - 0.3, 0.6), color=COLOURS[row])
        _draw_unplanned(axes, context, row)
        axes.text(t[0], row + 0.34, f" {name} foot carries", color=SOFT, fontsize="small")
    axes.set_ylabel("supports", color=INK)
    axes.grid(visible=True, axis="x", color=FAINT)


def _draw_unplanned(axes: Axes, context: RunContext, row: int) -> None:
    """Mark while a foot touched early, was late or lost; nothing in a log without phases."""
    if not context.has(PHASE):
        return
    t, codes = context.run.t, context.run[PHASE][:, row]
    for phase, colour in UNPLANNED.items():
        on = np.concatenate(([0], (codes == phase.code).astype(int), [0]))
        starts, ends = np.flatnonzero(np.diff(on) == 1), np.flatnonzero(np.diff(on) == -1) - 1
        bars = [(t[a], t[b] - t[a]) for a, b in zip(starts, ends, strict=True)]
        if not bars:
            continue
        known = axes.get_legend_handles_labels()[1]
        label = None if phase.name.lower() in known else phase.name.lower()
        axes.broken_barh(bars, (row - 0.14, 0.28), color=colour, label=label)
    if axes.get_legend_handles_labels()[1]:
        axes.set_ylim(top=2.1)  # room for the words
        axes.legend(loc="upper right", ncols=3)
