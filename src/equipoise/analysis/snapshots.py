"""A strip of snapshots: what the robot did, at a glance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.drawing import draw_scene, frame_stage
from equipoise.analysis.stage import Stage
from equipoise.analysis.style import INK, new_figure, styled
from equipoise.errors import InputError
from equipoise.runlog import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from equipoise.scenarios.places import Places

_WIDTH = 13.3  # [inch]
_WIDEST = 3.3  # [inch]
_CAPTION = 0.35  # [inch]


@styled
def snapshot_strip(
    run: Run,
    times: Sequence[float] | None = None,
    count: int = 6,
    *,
    places: Places | None = None,
) -> Figure:
    """Draw the robot in its world at `times` [s], all seen by one camera, side by side.

    Without times, `count` ticks are spread evenly over the run. Each picture shows the tick
    nearest to its time and bears that tick's time. `places` is built from the run's scenario
    unless given.

    Raises: InputError if the run has no ticks or no time is wanted; what reading the scenario
    raises.
    """
    ticks = _ticks(run, times, count)
    if places is None:
        from equipoise.scenarios.places import build_places
        from equipoise.scenarios.read import parse_scenario

        places = build_places(parse_scenario(run.scenario_text))
    stage = Stage(places.scene)
    camera = frame_stage(stage, run["q"][ticks])
    rows = -(-len(ticks) // 8)
    columns = -(-len(ticks) // rows)
    width = min(_WIDTH / columns, _WIDEST)
    figure = new_figure(columns * width, rows * (width / camera.aspect + _CAPTION))
    figure.set_layout_engine("none")
    share = _CAPTION / (width / camera.aspect + _CAPTION)
    for i, tick in enumerate(ticks):
        row, column = divmod(i, columns)
        bottom = 1.0 - (row + 1 - share) / rows
        axes = figure.add_axes((column / columns, bottom, 1.0 / columns, (1.0 - share) / rows))
        draw_scene(axes, _stage_at(places, stage, run, tick), run["q"][tick], camera)
        axes.text(
            0.5,
            -0.02,
            f"t = {run.t[tick]:.2f} s",
            transform=axes.transAxes,
            ha="center",
            va="top",
            fontsize=11,
            color=INK,
        )
    return figure


def _ticks(run: Run, times: Sequence[float] | None, count: int) -> list[int]:
    if not run.t.size:
        raise InputError("A run without ticks has nothing to show", given=run.folder.name)
    if times is None:
        if count < 1:
            raise InputError("A strip needs at least one snapshot", given=count)
        known = run.t[np.isfinite(run["q"]).all(axis=1)]
        if not known.size:
            raise InputError("No tick of the run has a finite configuration", given=run.folder.name)
        times = known[np.linspace(0, known.size - 1, count).round().astype(int)]
    ticks = list(dict.fromkeys(run.at(float(t)) for t in times))
    if not ticks:
        raise InputError("A strip needs at least one time", given=list(times))
    return ticks


def _stage_at(places: Places, stage: Stage, run: Run, tick: int) -> Stage:
    """Return the stage with pushed objects where they are at a tick."""
    travels = {
        name: float(run[f"slider/{name}"][tick, 0])
        for name in places.sliders
        if f"slider/{name}" in run
    }
    return Stage(places.scene_with(travels)) if travels else stage


def draw_snapshots(
    figure: Figure,
    run: Run,
    places: Places,
    box: tuple[float, float, float, float],
    count: int = 6,
) -> None:
    """Draw `count` snapshots side by side into a part of a figure.

    `box` is (left, bottom, right, top) as shares of the figure; times stand under the pictures.
    """
    left, bottom, right, top = box
    ticks = _ticks(run, None, count)
    stage = Stage(places.scene)
    camera = frame_stage(stage, run["q"][ticks])
    width = (right - left) / len(ticks)
    for k, tick in enumerate(ticks):
        axes = figure.add_axes((left + k * width, bottom + 0.03, width, top - bottom - 0.03))
        draw_scene(axes, _stage_at(places, stage, run, tick), run["q"][tick], camera)
        caption = f"t = {run.t[tick]:.2f} s"
        axes.text(0.5, -0.02, caption, transform=axes.transAxes, ha="center", va="top", color=INK)
