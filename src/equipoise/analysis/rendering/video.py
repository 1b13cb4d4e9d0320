"""A run as an MP4 video, drawn by MuJoCo without a display, written by ffmpeg."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
import pinocchio as pin

from equipoise.errors import EquipoiseError, InputError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.runlog import Run
from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build.setup import Setup, build_setup
from equipoise.spatial import POSE_SIZE, Array

if TYPE_CHECKING:
    from equipoise.physics.mujoco.engine import MujocoEngine


class NoVideoError(EquipoiseError):
    """A video cannot be made here; the message says what is missing."""


def write_video(
    run: Run,
    path: Path,
    *,
    fps: int = 25,
    size: tuple[int, int] = (960, 720),
    report: Callable[[float], None] | None = None,
) -> Path:
    """Write a video of a run in real time and return its path; `report` is told the share done.

    Raises: `InputError` if the run has no ticks or `path` can be no video, `NoVideoError` if
    drawing or writing fails here.
    """
    if not run.t.size:
        raise InputError("a run without ticks has nothing to show", given=run.folder.name)
    if path.suffix.lower() != ".mp4" or path.is_dir():
        remedy = "Name a file that ends in .mp4"
        raise InputError("a video is one MP4 file", given=str(path), remedy=remedy)
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        import imageio_ffmpeg

        from equipoise.physics.mujoco.view import MujocoView, NoPictureError, choose_offscreen

        choose_offscreen()
        import mujoco  # noqa: F401
    except ImportError as error:
        raise NoVideoError(f"{error}; install it with: pip install 'equipoise[mujoco]'") from None
    setup, engine = _engine_of(run)
    try:
        view = MujocoView(engine, *size)
    except NoPictureError as error:
        raise NoVideoError(str(error)) from error
    writer = imageio_ffmpeg.write_frames(str(path), size, fps=fps, codec="libx264", quality=7)
    try:
        writer.send(None)
        times = np.arange(run.t[0], run.t[-1], 1.0 / fps)
        for k, tick in enumerate(_ticks(run, times)):
            objects = _objects_at(run, setup, tick)
            writer.send(np.ascontiguousarray(view.image(run["q"][tick], objects)))
            if report is not None:
                report((k + 1) / len(times))
    except OSError as error:
        cause = str(error).splitlines()[0]
        raise NoVideoError(f"ffmpeg could not write {path} ({cause})") from error
    finally:
        writer.close()
        view.close()
    return path


def _ticks(run: Run, times: Array) -> Iterator[int]:
    for t in times:
        tick = run.at(float(t))
        if np.isfinite(run["q"][tick]).all():
            yield tick


def _engine_of(run: Run) -> tuple[Setup, MujocoEngine]:
    """Return setup and an engine whose model is the run's robot and world."""
    from equipoise.simulation.build.engines import make_engine

    scenario = parse_scenario(run.scenario_text)
    physics = scenario.physics.model_copy(update={"engine": "mujoco"})
    scenario = scenario.model_copy(update={"physics": physics})
    setup = build_setup(scenario)
    return setup, cast("MujocoEngine", make_engine(scenario, setup, run["q"][0]))


def _objects_at(run: Run, setup: Setup, tick: int) -> dict[str, pin.SE3]:
    """Return where held and pushed objects are at a tick, as logged or as the hands hold them."""
    found = {}
    kin = KinematicsEvaluator(setup.robot).at(run["q"][tick], np.zeros(setup.robot.nv))
    for (name, hand), T_object_hand in setup.handles.items():
        if name not in found:
            T_world_hand = kin.placement(setup.robot.frame_id(hand))
            found[name] = T_world_hand * T_object_hand.inverse()
    for name, direction in setup.sliders.items():
        body = next(body for body in setup.scene.bodies if body.name == name)
        T = body.T_parent_body
        travel = float(run[f"slider/{name}"][tick, 0]) if f"slider/{name}" in run else 0.0
        found[name] = pin.SE3(T.rotation, T.translation + travel * direction)
    for name in list(found):
        if f"object/{name}" in run:
            found[name] = pin.XYZQUATToSE3(run[f"object/{name}"][tick, :POSE_SIZE])
    return found
