"""Figure of the errors: posture, base, followed frames, regulated contact forces."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.story import Story
from equipoise.analysis.style import (
    COLOURS,
    INK,
    curve_look,
    draw_curve,
    label_time,
    new_figure,
    styled,
    zero_line,
)
from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Panel = Callable[["Axes"], None]


@styled
def errors_figure(story: Story) -> Figure | None:
    """Draw every error that was logged, a panel each; None without any."""
    panels = [*_posture_panels(story), *_frame_panels(story), *_force_panels(story)]
    if not panels:
        return None
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure = new_figure(4.44 * columns, 0.6 + 3.3 * rows, "Tracking errors of motion and force")
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes, panel in zip(grid.flat, panels, strict=False):
        panel(axes)
        label_time(axes, story.run.t)
        axes.legend(loc="best")
    for axes in grid.flat[len(panels) :]:
        axes.remove()
    return figure


def _posture_panels(story: Story) -> list[Panel]:
    if not story.has("dq") or story.run["dq"].shape[1] != 6 + len(story.joint_names):
        return []
    return [partial(_draw_posture, story), partial(_draw_base, story)]


def _draw_posture(story: Story, axes: Axes) -> None:
    error = 1e3 * np.abs(story.run["dq"][:, 6:])
    for k, limb in enumerate(story.limbs):
        largest = error[:, limb.joints].max(axis=1)
        look = curve_look(k, dashed=limb.title.startswith("Right"))
        draw_curve(axes, story.run.t, largest, label=limb.title, **look)
    axes.set_title("Posture: largest joint error of each limb")
    axes.set_ylabel("|q − q_ref| [mrad]")
    axes.set_ylim(bottom=0.0)


def _draw_base(story: Story, axes: Axes) -> None:
    error = story.run["dq"]
    position = 1e3 * np.linalg.norm(error[:, :3], axis=1)
    angle = 1e3 * np.linalg.norm(error[:, 3:6], axis=1)
    draw_curve(axes, story.run.t, position, color=COLOURS[0], label="position [mm]")
    draw_curve(axes, story.run.t, angle, color=COLOURS[1], label="orientation [mrad]")
    axes.set_title("Base: distance from its reference")
    axes.set_ylabel("error [mm], [mrad]")
    axes.set_ylim(bottom=0.0)


def _frame_panels(story: Story) -> list[Panel]:
    names = [name for name in story.followed_frames if story.run[f"error/{name}"].shape[1] == 6]
    if not story.has(*(f"error/{name}" for name in names)) or not names:
        return []
    return [
        partial(_draw_frames, story, names, slice(0, 3), 1e3, "Position", "mm"),
        partial(_draw_frames, story, names, slice(3, 6), 180.0 / np.pi, "Orientation", "deg"),
    ]


def _draw_frames(
    story: Story,
    names: list[str],
    part: slice,
    scale: float,
    what: str,
    unit: str,
    axes: Axes,
) -> None:
    for k, name in enumerate(names):
        error = scale * np.linalg.norm(story.run[f"error/{name}"][:, part], axis=1)
        look = curve_look(k, dashed=k % 2 == 1)
        draw_curve(axes, story.run.t, error, label=name.replace("_", " "), **look)
    axes.set_title(f"{what} error to the wanted trajectory")
    axes.set_ylabel(f"{what.lower()} error [{unit}]")
    axes.set_ylim(bottom=0.0)


def _force_panels(story: Story) -> list[Panel]:
    rows = regulated_rows(story)
    panels: list[Panel] = []
    for unit in dict.fromkeys(unit for *_, unit in rows):
        chosen = [row for row in rows if row[-1] == unit]
        panels.append(partial(_draw_forces, story, chosen, unit))
        panels.append(partial(_draw_force_errors, story, chosen, unit))
    return panels


def regulated_rows(story: Story) -> list[tuple[str, Array, Array, str]]:
    """Return name, wanted (N,) and achieved (N,) multiplier, and unit of each regulated row."""
    rows = []
    for channel in story.run.channels.values():
        contact = channel.name.removeprefix("lam_ref/")
        achieved = story.run.channels.get(f"lam/{contact}")
        if contact == channel.name or achieved is None or not story.has(channel.name):
            continue
        for k, label in enumerate(channel.labels):
            if label in achieved.labels:
                values = story.run[achieved.name][:, achieved.labels.index(label)]
                wanted = story.run[channel.name][:, k]
                rows.append((f"{contact} {label}", wanted, values, channel.units[k]))
    return rows


def _draw_forces(story: Story, rows: list, unit: str, axes: Axes) -> None:
    for k, (name, wanted, achieved, _) in enumerate(rows):
        colour = COLOURS[k % len(COLOURS)]
        draw_curve(
            axes, story.run.t, achieved, color=colour, label=f"{name}: achieved", linewidth=2
        )
        look = {"color": INK, "linestyle": (0, (4, 3)), "linewidth": 1.0}
        draw_curve(axes, story.run.t, wanted, label=f"{name}: wanted", **look)
    kind = "moment" if unit == "N m" else "force"
    axes.set_title(f"Regulated contact {kind}: wanted and achieved")
    axes.set_ylabel(f"{kind} [{unit}]")


def _draw_force_errors(story: Story, rows: list, unit: str, axes: Axes) -> None:
    zero_line(axes)
    for k, (name, wanted, achieved, _) in enumerate(rows):
        error = achieved - wanted
        rms = float(np.sqrt(np.mean(error**2)))
        label = f"{name} (RMS {rms:.3g} {unit})"
        draw_curve(axes, story.run.t, error, color=COLOURS[k % len(COLOURS)], label=label)
    kind = "moment" if unit == "N m" else "force"
    axes.set_title(f"Error of the regulated {kind}")
    axes.set_ylabel(f"achieved − wanted [{unit}]")
