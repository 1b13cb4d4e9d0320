"""A strip of snapshots: what the robot did, at a glance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.figures.style import INK, new_figure, styled
from equipoise.analysis.rendering.axes3d import draw_scene, frame_scene
from equipoise.analysis.rendering.camera import Camera
from equipoise.analysis.rendering.scene_meshes import SceneMeshes
from equipoise.analysis.run_context import RunContext
from equipoise.errors import InputError
from equipoise.runlog import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from equipoise.simulation.build.setup import Setup

_WIDTH = 13.3  # [inch]
_WIDEST = 3.3  # [inch]
_CAPTION = 0.35  # [inch]


def run_strip(context: RunContext) -> Figure | None:
    """Draw the strip of a whole run; None where the robot or its configurations are not known."""
    return snapshot_strip(context.run, setup=context.setup) if context.drawable else None


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
    nearest to its time and bears that tick's time. `setup` is built from the run's scenario
    unless given.

    Raises: InputError if the run has no ticks or no time is wanted; what reading the scenario
    raises.
    """
    ticks = _ticks(run, times, count)
    if setup is None:
        from equipoise.scenarios.read import parse_scenario
        from equipoise.simulation.build.setup import build_setup

        setup = build_setup(parse_scenario(run.scenario_text))
    scene_meshes = SceneMeshes(setup.scene, frozenset(setup.sliders))
    camera = frame_scene(scene_meshes, run["q"][ticks])
    rows = -(-len(ticks) // 8)
    columns = -(-len(ticks) // rows)
    width = min(_WIDTH / columns, _WIDEST)
    figure = new_figure(columns * width, rows * (width / camera.aspect + _CAPTION))
    share = _CAPTION / (width / camera.aspect + _CAPTION)
    for i, tick in enumerate(ticks):
        row, column = divmod(i, columns)
        bottom = 1.0 - (row + 1 - share) / rows
        box = (column / columns, bottom, 1.0 / columns, (1.0 - share) / rows)
        picture = _Picture(run, tick, _meshes_at(setup, scene_meshes, run, tick), camera)
        _draw_picture(figure, box, picture, size=11.0)
    return figure


@dataclass(frozen=True)
class _Picture:
    """What a picture shows, and the camera that sees it."""

    run: Run
    tick: int
    meshes: SceneMeshes
    camera: Camera


def _draw_picture(
    figure: Figure,
    box: tuple[float, float, float, float],
    picture: _Picture,
    size: float | None = None,
) -> None:
    """Draw a picture into a box of a figure (left, bottom, width, height), its time below it.

    `size` is that of the text, else it is that of every text.
    """
    from matplotlib import rc_context

    with rc_context({"axes.grid": False}):
        axes = figure.add_axes(box)
    draw_scene(axes, picture.meshes, picture.run["q"][picture.tick], picture.camera)
    caption = f"t = {picture.run.t[picture.tick]:.2f} s"
    axes.text(
        0.5, -0.02, caption, ha="center", va="top", color=INK, transform=axes.transAxes,
        fontsize=size,
    )  # fmt: skip


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
    return SceneMeshes(setup.scene_with(travels), frozenset(travels)) if travels else scene_meshes


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
    scene_meshes = SceneMeshes(setup.scene, frozenset(setup.sliders))
    camera = frame_scene(scene_meshes, run["q"][ticks])
    width = (right - left) / len(ticks)
    for k, tick in enumerate(ticks):
        place = (left + k * width, bottom + 0.03, width, top - bottom - 0.03)
        picture = _Picture(run, tick, _meshes_at(setup, scene_meshes, run, tick), camera)
        _draw_picture(figure, place, picture)
