"""Figures of the joints: positions and velocities with their references, and torques."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.figures.layout import (
    NAMED,
    NUMBERS,
    RIM,
    SIDE,
    SIDE_NUMBERS,
    TITLE,
    Row,
    axes_grid,
    legend_below,
    legend_height,
    text_width,
    whole,
)
from equipoise.analysis.figures.style import (
    ALARM,
    COLOURS,
    INK,
    SOFT,
    Look,
    draw_curve,
    draw_together,
    finite,
    label_time,
    new_figure,
    number,
    styled,
    zero_line,
)
from equipoise.analysis.joint_groups import JointGroup
from equipoise.analysis.run_context import RunContext
from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_COLUMNS = 5
_LETTERS, _SHARE_LETTERS = 30, 46  # of a line of a legend


@styled
def joints_figure(context: RunContext) -> Figure | None:
    """Draw joint positions and velocities of each limb, references dashed; None without `q`."""
    count, joint_groups = len(context.joint_names), context.joint_groups
    rows = [
        (name, reference, skip)
        for name, reference, skip in (("q", "q_ref", 7), ("v", "v_ref", 6))
        if context.has(name) and context.run[name].shape[1] == skip + count
    ]
    if not rows or not joint_groups:
        return None
    columns = min(len(joint_groups), _MOST_COLUMNS)
    bands = -(-len(joint_groups) // columns)
    figure = new_figure(1.2 + 2.9 * columns, 0.8 + 3.3 * len(rows) * bands, _joints_title(context))
    sides = [SIDE, *(SIDE_NUMBERS,) * (columns - 1)]
    grid = axes_grid(figure, whole(figure), sides, _bands(context, len(rows), columns))
    for k, limb in enumerate(joint_groups):
        band, column = divmod(k, columns)
        for r, (name, reference, skip) in enumerate(rows):
            axes = grid[band * len(rows) + r][column]
            _draw_limb(axes, context, limb, name, reference, skip)
            if column == 0:
                axes.set_ylabel(_quantity(context, name, limb, skip))
            if r == 0:
                axes.set_title(limb.title)
        label_time(axes, context.run.t)
        legend_below(axes, _LETTERS)
    for axes in chain(*grid):
        if not axes.lines:
            axes.remove()
    return figure


def _bands(context: RunContext, rows: int, columns: int) -> list[Row]:
    """Return the rows of axes: in each band, `rows` under each other and legends below the last."""
    groups, bands = context.joint_groups, []
    for first in range(0, len(groups), columns):
        labels = [g.short_names(context.joint_names) for g in groups[first : first + columns]]
        legends = max(legend_height(names, _LETTERS) for names in labels)
        for r in range(rows):
            below = NAMED + legends if r == rows - 1 else NUMBERS
            bands.append(Row(TITLE if r == 0 else RIM, below))
    return bands


def _draw_limb(
    axes: Axes, context: RunContext, limb: JointGroup, name: str, reference: str, skip: int
) -> None:
    t = context.run.t
    values = context.run[name][:, skip:]
    wanted = context.run[reference][:, skip:] if context.has(reference) else None
    zero_line(axes)
    for joint, label, colour in zip(
        limb.joints, limb.short_names(context.joint_names), COLOURS, strict=False
    ):
        draw_curve(axes, t, values[:, joint], color=colour, label=label, linewidth=2.0, alpha=0.85)
    if wanted is not None:
        look: Look = {"color": INK, "linewidth": 0.8, "linestyle": (0, (4, 3))}
        draw_together(axes, t, wanted[:, list(limb.joints)], **look)
    label_time(axes, t)
    axes.set_xlabel("")


def _quantity(context: RunContext, name: str, limb: JointGroup, skip: int) -> str:
    unit = context.run.channels[name].units[skip + limb.joints[0]]
    return f"{'joint position' if name == 'q' else 'joint velocity'} [{unit}]"


def _joints_title(context: RunContext) -> str:
    title = "Joint positions and velocities"
    if context.has("q", "q_ref"):
        title += "; dashed: reference"
        error = np.abs(context.run["q"] - context.run["q_ref"])[:, 7:]
        tick, joint = _peak(error)
        title += (
            f" (largest error {1e3 * error[tick, joint]:.2g} mrad,"
            f" {context.joint_names[joint]} at {context.run.t[tick]:.2f} s)"
        )
    return title


def _peak(values: Array) -> tuple[int, int]:
    """Return tick and column of the largest finite value (N, k), none of them negative."""
    tick, column = np.unravel_index(np.argmax(finite(values)), values.shape)
    return int(tick), int(column)


@styled
def torques_figure(context: RunContext) -> Figure | None:
    """Draw torques as shares of their limits, by limb, and the joints that come nearest to them."""
    if not context.has("tau") or not context.known:
        return None
    robot = context.setup.robot
    if robot.joint_names != context.joint_names:
        return None
    share = 100.0 * context.run["tau"] / robot.tau_max
    tick, joint = _peak(np.abs(share))
    joint_groups = context.joint_groups
    columns = 3
    rows = -(-(len(joint_groups) + 1) // columns)
    title = (
        f"Joint torques as share of their limits (largest: {share[tick, joint]:.0f} %,"
        f" {robot.joint_names[joint]} at {context.run.t[tick]:.2f} s)"
    )
    figure = new_figure(13.3, 0.6 + 3.7 * rows, title)
    labels = [group.short_names(robot.joint_names) for group in joint_groups]
    below = NAMED + max(legend_height(names, _SHARE_LETTERS) for names in labels)
    sides = [SIDE] * columns
    sides[len(joint_groups) % columns] = 0.2 + text_width(robot.joint_names)
    places = list(chain(*axes_grid(figure, whole(figure), sides, [Row(below=below)] * rows)))
    reach = max(115.0, 1.1 * float(np.abs(finite(share)).max()))
    for axes, limb in zip(places, joint_groups, strict=False):
        _draw_shares(axes, context, limb, share, reach)
    _draw_peaks(places[len(joint_groups)], share, robot.joint_names)
    for axes in places[len(joint_groups) + 1 :]:
        axes.remove()
    return figure


def _draw_shares(
    axes: Axes, context: RunContext, limb: JointGroup, share: Array, reach: float
) -> None:
    t = context.run.t
    names = limb.short_names(context.joint_names)
    for side in (-100.0, 100.0):
        axes.axhline(side, color=ALARM, linewidth=1.0, linestyle="--")
    zero_line(axes)
    for joint, label, colour in zip(limb.joints, names, COLOURS, strict=False):
        draw_curve(axes, t, share[:, joint], color=colour, label=label, linewidth=1.3)
    tick, k = _peak(np.abs(share[:, limb.joints]))
    peak = share[tick, limb.joints[k]]
    axes.plot(t[tick], peak, "o", color=INK, markersize=4, clip_on=False)
    right = t[tick] > t[0] + 0.6 * (t[-1] - t[0])
    axes.annotate(
        f"{names[k]}: {number(peak, '.0f')} %",
        (t[tick], peak),
        xytext=(-6 if right else 6, 8 if peak >= 0.0 else -8),
        textcoords="offset points",
        ha="right" if right else "left",
        va="bottom" if peak >= 0.0 else "top",
        fontsize=9,
        fontweight="bold",
    )
    axes.set_title(limb.title)
    axes.set_ylim(-reach, reach)
    axes.set_yticks([-100, -50, 0, 50, 100])
    axes.set_ylabel("torque / limit [%]")
    label_time(axes, t)
    legend_below(axes, _SHARE_LETTERS)


def _draw_peaks(axes: Axes, share: Array, names: tuple[str, ...], count: int = 10) -> None:
    peaks = np.abs(finite(share)).max(axis=0)
    order = np.argsort(peaks)[::-1][:count][::-1]
    axes.barh([names[i] for i in order], peaks[order], color=COLOURS[0], height=0.65)
    for row, i in enumerate(order):
        axes.text(peaks[i] + 1.5, row, f"{peaks[i]:.0f}", va="center", fontsize=9, color=INK)
    axes.axvline(100.0, color=ALARM, linewidth=1.0, linestyle="--")
    axes.set_xlim(0.0, max(110.0, 1.1 * float(peaks.max())))
    axes.set_title("Largest share of each joint over the run")
    axes.set_xlabel("|torque| / limit [%]")
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0, colors=SOFT, labelcolor=INK)
