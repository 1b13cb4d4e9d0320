"""Films: as long as they should be, seen by the camera asked for, with the forces in them."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise import run_scenario
from equipoise.analysis.rendering.run_pictures import MEASURED, WANTED, RunPictures, arrow_mesh
from equipoise.analysis.rendering.shots import presets, shot
from equipoise.analysis.rendering.video import Style, write_still, write_video
from equipoise.analysis.run_context import RunContext
from equipoise.errors import InputError

SMALL = Style(size=(160, 90))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("film") / "run"
    return run_scenario("press", out=folder, overrides=["duration=0.5"], figures=False)


@pytest.mark.parametrize("speed", [1.0, 0.5])
def test_a_film_lasts_as_long_as_the_run_at_its_speed(run, tmp_path, speed):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="needs the extra 'film'")
    path = write_video([run, run], tmp_path / "a.mp4", Style(size=(160, 90), speed=speed))
    frames = ffmpeg.read_frames(str(path))
    assert next(frames)["size"] == (320, 90)
    frames.close()
    count, _ = ffmpeg.count_frames_and_secs(str(path))
    assert count == pytest.approx((run.t[-1] - run.t[0]) * 25 / speed, abs=1.0)


@pytest.mark.parametrize("preset", presets())
def test_every_camera_sees_the_robot(run, preset):
    pictures = RunPictures(RunContext.of(run))
    tick = int(pictures.ticks[-1])
    camera = shot(pictures, preset, 16 / 9)(tick)
    assert camera.aspect == pytest.approx(16 / 9)
    points = camera.project(pictures.robot_points(tick))[:, :2]
    x_min, x_max, y_min, y_max = camera.window
    inside = (points > [x_min, y_min]) & (points < [x_max, y_max])
    seen = inside.all(axis=1).mean()
    assert seen == 1.0 if preset != "hands" else seen > 0.3
    kin = pictures.kinematics(tick)
    hands = np.array([kin.placement(pictures.setup.robot.frame_id(p.frame)).translation
                      for p in pictures.setup.robot.palms])  # fmt: skip
    hands = camera.project(hands)[:, :2]
    assert ((hands > [x_min, y_min]) & (hands < [x_max, y_max])).all()


def test_arrows_measured_and_wanted_are_in_the_picture(run):
    context = RunContext.of(run)
    tick = int(RunPictures(context).ticks[-1])
    shown = {tuple(rgb) for rgb in RunPictures(context).at(tick).rgb}
    hidden = {tuple(rgb) for rgb in RunPictures(context, arrows=False).at(tick).rgb}
    assert shown - hidden == {tuple(MEASURED), tuple(WANTED)}


def test_an_arrow_goes_from_tail_to_tip():
    tail, tip = np.array([0.1, -0.2, 0.3]), np.array([0.4, 0.1, 0.9])
    way = (tip - tail) / np.linalg.norm(tip - tail)
    along = np.hstack([(mesh.vertices - tail) @ way for mesh in arrow_mesh(np.array([tail, tip]))])
    assert along.min() == pytest.approx(0.0, abs=1e-9)
    assert along.max() == pytest.approx(np.linalg.norm(tip - tail))
    assert arrow_mesh(np.array([tail, tail])) == []


def test_a_still_is_the_same_every_time_and_another_at_another_time(run, tmp_path):
    first = write_still(run, tmp_path / "a.png", 0.1, SMALL).read_bytes()
    assert write_still(run, tmp_path / "b.png", 0.1, SMALL).read_bytes() == first
    assert write_still(run, tmp_path / "c.png", 0.4, SMALL).read_bytes() != first
    with pytest.raises(InputError, match=r"end in \.png"):
        write_still(run, tmp_path / "c.jpg", 0.4, SMALL)
    with pytest.raises(InputError, match="pixels a side"):
        Style(size=(10, 90))
