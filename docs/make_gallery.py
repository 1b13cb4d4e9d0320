"""Runs the scenarios of the gallery and draws its pictures: `python docs/make_gallery.py`.

Each run takes some seconds; runs that are there already (in `--runs`) are taken as they are.
The film of the first page is an animated GIF, since package indexes play nothing else.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from equipoise import run_scenario
from equipoise.analysis.rendering.video import Style, View, write_still
from equipoise.errors import RunLogError
from equipoise.runlog import Run, load_run

IMAGES = Path(__file__).parent / "images"
SIZE = (640, 420)
FILM = ("tray", (480, 300), 10)  # picture, pixels, pictures a second
COLOURS = 128


@dataclass(frozen=True)
class Picture:
    """A picture of the gallery: a scenario on a robot, a moment [s], a camera."""

    name: str
    scenario: str
    t: float
    camera: str = "quarter"
    robot: str | None = None


PICTURES = (
    Picture("tray", "tray", 4.2),
    Picture("tray_hands", "tray", 4.6, "hands"),
    Picture("telephone", "telephone", 3.0, "hands"),
    Picture("press_talos", "press", 3.0, robot="talos"),
    Picture("press_g1", "press", 3.0, robot="g1"),
    Picture("press_romeo", "press", 3.0, robot="romeo"),
    Picture("sphere", "sphere", 5.0),
    Picture("two_arms", "two_arms", 2.5),
)


def main() -> None:
    """Make what is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=Path, default=Path("runs/gallery"))
    parser.add_argument("--to", type=Path, default=IMAGES)
    asked = parser.parse_args()
    for one in PICTURES:
        run = run_of(one, asked.runs)
        path = asked.to / f"gallery_{one.name}.png"
        print(write_still(run, path, one.t, Style(size=SIZE, camera=one.camera)))
        if one.name == FILM[0]:
            print(film(run, asked.to / f"{one.name}.gif"))


def run_of(picture: Picture, folder: Path) -> Run:
    """Return the run of a picture, from before if there is one."""
    place = folder / f"{picture.scenario}-{picture.robot or 'own'}"
    try:
        return load_run(place)
    except RunLogError:
        return run_scenario(picture.scenario, robot=picture.robot, out=place, figures=False)


def film(run: Run, path: Path) -> Path:
    """Write a run as an animated GIF."""
    _, size, fps = FILM
    view = View(run, Style(size=size))
    frames = []
    for t in np.arange(run.t[0], run.t[-1], 1.0 / fps):
        frames.append(Image.fromarray(view.image(float(t))).quantize(COLOURS, dither=0))
    frames[0].save(
        path, save_all=True, append_images=frames[1:], duration=1000 // fps, loop=0, optimize=True
    )
    return path


if __name__ == "__main__":
    main()
