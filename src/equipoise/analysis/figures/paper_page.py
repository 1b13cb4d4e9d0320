"""One page a run in the arrangement of the paper's Figures 2 and 3.

Snapshots above; below them, on the left, joint and velocity profiles; on the right position,
velocity and normal-force errors.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.figures.error import regulated_rows
from equipoise.analysis.figures.snapshots import draw_snapshots
from equipoise.analysis.figures.style import (
    COLOURS,
    INK,
    Look,
    draw_curve,
    draw_together,
    label_time,
    new_figure,
    save,
    styled,
    zero_line,
)
from equipoise.analysis.joint_groups import JointGroup
from equipoise.analysis.run_context import RunContext
from equipoise.errors import InputError
from equipoise.runlog import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BESIDE, _ABOVE = 2.8, 1.0  # [pt] of lines of left limbs and of all others
_WIDTH, _STRIP, _PLOTS = 13.3, 2.9, 5.6  # [inch]


def write_paper_page(run: Run, folder: Path) -> list[Path]:
    """Write `<scenario>_page.png` and `.pdf` of a run into `folder`; return their paths.

    Raises: `InputError` if the run has no ticks or its scenario cannot be read.
    """
    context = RunContext.of(run)
    if not context.drawable:
        raise InputError(
            "there is nothing to draw a page of",
            given=str(run.folder),
            remedy="Give a run of a scenario that this version can read, with at least one tick",
        )
    figure = paper_page(context)
    folder.mkdir(parents=True, exist_ok=True)
    name = context.scenario.name if context.known else "run"
    return [save(figure, folder / f"{name}_page{ending}") for ending in (".png", ".pdf")]


@styled
def paper_page(context: RunContext) -> Figure:
    """Return the page. Source: Figures 2 and 3. Differs: units, references drawn, no base."""
    figure = new_figure(_WIDTH, _STRIP + _PLOTS, context.scenario.title if context.known else "")
    height = _STRIP + _PLOTS
    top = 1.0 - 0.4 / height
    draw_snapshots(figure, context.run, context.setup, (0.01, _PLOTS / height, 0.98, top))
    grid = figure.add_gridspec(
        2,
        3,
        left=0.055,
        right=0.99,
        bottom=0.075,
        top=_PLOTS / height - 0.09,
        wspace=0.24,
        hspace=0.5,
    )
    left = [figure.add_subplot(grid[row, 0]) for row in (0, 1)]
    _draw_profiles(context, left[0], "q", "q_ref", 7, "Joint positions", "q [rad]")
    _draw_profiles(context, left[1], "v", "v_ref", 6, "Joint velocities", "v [rad/s]")
    _draw_joint_errors(context, figure.add_subplot(grid[0, 1]), "q")
    _draw_joint_errors(context, figure.add_subplot(grid[1, 1]), "v")
    _draw_force(context, figure.add_subplot(grid[0, 2]))
    _draw_force_error(context, figure.add_subplot(grid[1, 2]))
    handles, joint_groups = left[0].get_legend_handles_labels()
    figure.legend(
        handles,
        joint_groups,
        loc="center",
        bbox_to_anchor=(0.5, _PLOTS / height - 0.025),
        ncols=len(joint_groups),
        fontsize=9,
    )
    for axes in figure.axes[-6:]:
        label_time(axes, context.run.t)
    return figure


def _width(limb: JointGroup) -> float:
    """Return how wide a limb is drawn: a left one so that the right one on top leaves its rims."""
    return _BESIDE if limb.title.startswith("Left") else _ABOVE


def _draw_profiles(
    context: RunContext, axes: Axes, name: str, reference: str, skip: int, title: str, label: str
) -> None:
    """Draw every joint, coloured by limb; the reference lies dashed on top."""
    t = context.run.t
    for k, limb in _left_first(context.joint_groups):
        for number, joint in enumerate(limb.joints):
            look: Look = {"color": COLOURS[k % len(COLOURS)], "linewidth": _width(limb)}
            caption = limb.title if number == 0 else "_nolegend_"
            draw_curve(axes, t, context.run[name][:, skip + joint], label=caption, **look)
    dashed: Look = {"color": INK, "linewidth": 0.5, "linestyle": (0, (4, 4))}
    draw_together(axes, t, context.run[reference][:, skip:], **dashed)
    axes.set_title(f"{title} (dashed: wanted)")
    axes.set_ylabel(label)


def _left_first(limbs: list[JointGroup]) -> list[tuple[int, JointGroup]]:
    """Return the limbs with their numbers, those first that others lie on."""
    return sorted(enumerate(limbs), key=lambda numbered: -_width(numbered[1]))


def _draw_joint_errors(context: RunContext, axes: Axes, name: str) -> None:
    """Draw the largest error of each limb's joints."""
    skip, unit = (7, "mrad") if name == "q" else (6, "mrad/s")
    error = 1e3 * (context.run[name] - context.run[f"{name}_ref"])[:, skip:]
    for k, limb in _left_first(context.joint_groups):
        largest = np.abs(error[:, list(limb.joints)]).max(axis=1)
        colour = COLOURS[k % len(COLOURS)]
        draw_curve(axes, context.run.t, largest, color=colour, linewidth=_width(limb))
    axes.set_title("Position error" if name == "q" else "Velocity error")
    axes.set_ylabel(f"largest of a limb [{unit}]")


def _draw_force(context: RunContext, axes: Axes) -> None:
    for k, (name, wanted, achieved, unit) in enumerate(regulated_rows(context)):
        colour = COLOURS[k % len(COLOURS)]
        draw_curve(axes, context.run.t, achieved, color=colour, label=name, linewidth=1.4)
        look: Look = {"color": INK, "linewidth": 0.8, "linestyle": (0, (4, 3))}
        draw_curve(axes, context.run.t, wanted, label=f"{name} wanted", **look)
        axes.set_ylabel(f"[{unit}]")
    axes.set_title("Normal force")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8)


def _draw_force_error(context: RunContext, axes: Axes) -> None:
    zero_line(axes)
    for k, (_, wanted, achieved, unit) in enumerate(regulated_rows(context)):
        colour = COLOURS[k % len(COLOURS)]
        draw_curve(axes, context.run.t, achieved - wanted, color=colour, linewidth=1.2)
        axes.set_ylabel(f"achieved \N{MINUS SIGN} wanted [{unit}]")
    axes.set_title("Normal-force error")
