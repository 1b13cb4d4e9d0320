"""A strip of snapshots: what the robot did, at a glance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.figures.style import INK, new_figure, styled
from equipoise.analysis.rendering.axes3d import draw_scene, frame_scene
from equipoise.analysis.rendering.scene_meshes import SceneMeshes
from equipoise.errors import InputError
from equipoise.runlog import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from equipoise.simulation.build.setup import Setup

_WIDTH = 13.3  # [inch]
_WIDEST = 3.3  # [inch]
_CAPTION = 0.35  # [inch]


@styled
def snapshot_strip(
    run: Run,
    times: Sequence[float] | None = None,
    count: int = 6,
    *,
    setup: Setup | None = None,
) -> Figure:
    """Draw the robot in its world at `times` [s], all seen by one camera, side by side.

    Without times, `count` ticks are spread evenly over the run. Each picture shows the tick
    nearest to its time and bears that tick's time. `places` is built from the run's scenario
    unless given.

    Raises: InputError if the run has no ticks or no time is wanted; what reading the scenario
    raises.
    """
    ticks = _ticks(run, times, count)
    if setup is None:
        from equipoise.scenarios.read import parse_scenario
        from equipoise.simulation.build.setup import build_setup

        setup = build_setup(parse_scenario(run.scenario_text))
    scene_meshes = SceneMeshes(setup.scene)
    camera = frame_scene(scene_meshes, run["q"][ticks])
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
        draw_scene(axes, _meshes_at(setup, scene_meshes, run, tick), run["q"][tick], camera)
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


def _meshes_at(setup: Setup, scene_meshes: SceneMeshes, run: Run, tick: int) -> SceneMeshes:
    """Return the scene_meshes with pushed objects where they are at a tick."""
    travels = {
        name: float(run[f"slider/{name}"][tick, 0])
        for name in setup.sliders
        if f"slider/{name}" in run
    }
    return SceneMeshes(setup.scene_with(travels)) if travels else scene_meshes


def draw_snapshots(
    figure: Figure,
    run: Run,
    setup: Setup,
    box: tuple[float, float, float, float],
    count: int = 6,
) -> None:
    """Draw `count` snapshots side by side into a part of a figure.

    `box` is (left, bottom, right, top) as shares of the figure; times stand under the pictures.
    """
    left, bottom, right, top = box
    ticks = _ticks(run, None, count)
    scene_meshes = SceneMeshes(setup.scene)
    camera = frame_scene(scene_meshes, run["q"][ticks])
    width = (right - left) / len(ticks)
    for k, tick in enumerate(ticks):
        axes = figure.add_axes((left + k * width, bottom + 0.03, width, top - bottom - 0.03))
        draw_scene(axes, _meshes_at(setup, scene_meshes, run, tick), run["q"][tick], camera)
        caption = f"t = {run.t[tick]:.2f} s"
        axes.text(0.5, -0.02, caption, transform=axes.transAxes, ha="center", va="top", color=INK)
