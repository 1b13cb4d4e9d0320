"""Figure of the errors: posture, base, followed frames, regulated contact forces."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.figures.layout import SIDE, Row, axes_grid, whole
from equipoise.analysis.figures.style import (
    COLOURS,
    INK,
    Look,
    curve_look,
    draw_curve,
    label_time,
    new_figure,
    styled,
    zero_line,
)
from equipoise.analysis.run_context import RunContext
from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Panel = Callable[["Axes"], None]
ForceRow = tuple[str, Array, Array, str]  # name, wanted and achieved (N,), unit


@styled
def errors_figure(context: RunContext) -> Figure | None:
    """Draw every error that was logged, a panel each; None without any."""
    panels = [*_posture_panels(context), *_frame_panels(context), *_force_panels(context)]
    if not panels:
        return None
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure = new_figure(4.44 * columns, 0.6 + 3.3 * rows, "Tracking errors of motion and force")
    places = list(chain(*axes_grid(figure, whole(figure), [SIDE] * columns, [Row()] * rows)))
    for axes, panel in zip(places, panels, strict=False):
        panel(axes)
        label_time(axes, context.run.t)
        axes.legend(loc="best")
    for axes in places[len(panels) :]:
        axes.remove()
    return figure


def _posture_panels(context: RunContext) -> list[Panel]:
    if not context.has("dq"):
        return []
    base = context.run["dq"].shape[1] - len(context.joint_names)
    panels: list[Panel] = [partial(_draw_posture, context)] if base in (0, 6) else []
    return [*panels, partial(_draw_base, context)] if base == 6 else panels


def _draw_posture(context: RunContext, axes: Axes) -> None:
    error = 1e3 * np.abs(context.run["dq"][:, -len(context.joint_names) :])
    for k, limb in enumerate(context.joint_groups):
        largest = error[:, limb.joints].max(axis=1)
        look = curve_look(k, dashed=limb.title.startswith("Right"))
        draw_curve(axes, context.run.t, largest, label=limb.title, **look)
    axes.set_title("Posture: largest joint error of each limb")
    axes.set_ylabel("|q − q_ref| [mrad]")
    axes.set_ylim(bottom=0.0)


def _draw_base(context: RunContext, axes: Axes) -> None:
    error = context.run["dq"]
    position = 1e3 * np.linalg.norm(error[:, :3], axis=1)
    angle = 1e3 * np.linalg.norm(error[:, 3:6], axis=1)
    draw_curve(axes, context.run.t, position, color=COLOURS[0], label="position [mm]")
    draw_curve(axes, context.run.t, angle, color=COLOURS[1], label="orientation [mrad]")
    axes.set_title("Base: distance from its reference")
    axes.set_ylabel("error [mm], [mrad]")
    axes.set_ylim(bottom=0.0)


def _frame_panels(context: RunContext) -> list[Panel]:
    names = [name for name in context.followed_frames if context.run[f"error/{name}"].shape[1] == 6]
    if not context.has(*(f"error/{name}" for name in names)) or not names:
        return []
    return [
        partial(_draw_frames, context, names, slice(0, 3), 1e3, "Position", "mm"),
        partial(_draw_frames, context, names, slice(3, 6), 180.0 / np.pi, "Orientation", "deg"),
    ]


def _draw_frames(
    context: RunContext,
    names: list[str],
    part: slice,
    scale: float,
    what: str,
    unit: str,
    axes: Axes,
) -> None:
    for k, name in enumerate(names):
        error = scale * np.linalg.norm(context.run[f"error/{name}"][:, part], axis=1)
        look = curve_look(k, dashed=k % 2 == 1)
        draw_curve(axes, context.run.t, error, label=name.replace("_", " "), **look)
    axes.set_title(f"{what} error to the wanted trajectory")
    axes.set_ylabel(f"{what.lower()} error [{unit}]")
    axes.set_ylim(bottom=0.0)


def _force_panels(context: RunContext) -> list[Panel]:
    rows = regulated_rows(context)
    panels: list[Panel] = []
    for unit in dict.fromkeys(unit for *_, unit in rows):
        chosen = [row for row in rows if row[-1] == unit]
        panels.append(partial(_draw_forces, context, chosen, unit))
        panels.append(partial(_draw_force_errors, context, chosen, unit))
    return panels


def regulated_rows(context: RunContext) -> list[ForceRow]:
    """Return name, wanted (N,) and achieved (N,) multiplier, and unit of each regulated row."""
    rows = []
    for channel in context.run.channels.values():
        contact = channel.name.removeprefix("lam_ref/")
        achieved = context.run.channels.get(f"lam/{contact}")
        if contact == channel.name or achieved is None or not context.has(channel.name):
            continue
        for k, label in enumerate(channel.labels):
            if label in achieved.labels:
                values = context.run[achieved.name][:, achieved.labels.index(label)]
                wanted = context.run[channel.name][:, k]
                rows.append((f"{contact} {label}", wanted, values, channel.units[k]))
    return rows


def _draw_forces(context: RunContext, rows: list[ForceRow], unit: str, axes: Axes) -> None:
    for k, (name, wanted, achieved, _) in enumerate(rows):
        colour = COLOURS[k % len(COLOURS)]
        draw_curve(
            axes, context.run.t, achieved, color=colour, label=f"{name}: achieved", linewidth=2
        )
        look: Look = {"color": INK, "linestyle": (0, (4, 3)), "linewidth": 1.0}
        draw_curve(axes, context.run.t, wanted, label=f"{name}: wanted", **look)
    kind = "moment" if unit == "N m" else "force"
    axes.set_title(f"Regulated contact {kind}: wanted and achieved")
    axes.set_ylabel(f"{kind} [{unit}]")


def _draw_force_errors(context: RunContext, rows: list[ForceRow], unit: str, axes: Axes) -> None:
    zero_line(axes)
    for k, (name, wanted, achieved, _) in enumerate(rows):
        error = achieved - wanted
        rms = float(np.sqrt(np.mean(error**2)))
        label = f"{name} (RMS {rms:.3g} {unit})"
        draw_curve(axes, context.run.t, error, color=COLOURS[k % len(COLOURS)], label=label)
    kind = "moment" if unit == "N m" else "force"
    axes.set_title(f"Error of the regulated {kind}")
    axes.set_ylabel(f"achieved − wanted [{unit}]")
