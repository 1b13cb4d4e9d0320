"""Runs the scenarios of the gallery and draws its pictures: `python docs/make_gallery.py`.

With `--small` it draws little pictures of the first moments of three scenarios; a test does so.

Each run takes some seconds; runs that are there already (in `--runs`) are taken as they are.
Films are animated GIFs, since package indexes play nothing else.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from equipoise import run_scenario
from equipoise.analysis.rendering.video import Style, View, write_still
from equipoise.errors import RunLogError
from equipoise.runlog import Run, load_run

IMAGES = Path(__file__).parent / "images"
SIZE, SMALL_SIZE = (640, 420), (240, 160)  # pixels
SMALL = ("tray", "telephone", "sphere")
BRIEF, SEEN = 0.12, 0.1  # [s] of a small run, and when its picture is taken
FILM_SIZE, FILM_RATE = (480, 300), 10  # pixels, pictures a second
COLOURS, RARE_TOO = 128, Image.Quantize.MAXCOVERAGE  # arrows are thin, and red


@dataclass(frozen=True)
class Picture:
    """A picture of the gallery: a scenario on a robot, a moment [s], a camera."""

    name: str
    scenario: str
    t: float
    camera: str = "quarter"
    robot: str | None = None
    film: bool = False


PICTURES = (
    Picture("tray", "tray", 4.2, film=True),
    Picture("tray_hands", "tray", 4.6, "hands"),
    Picture("telephone", "telephone", 3.0, "hands"),
    Picture("walk", "walk", 3.2, "follow", film=True),
    Picture("lean", "lean", 5.0, "side", film=True),
    Picture("walk_tray", "walk_tray", 5.2, "follow", film=True),
    Picture("push_box", "push_box", 5.0, "side", film=True),
    Picture("press_talos", "press", 3.0, robot="talos"),
    Picture("press_g1", "press", 3.0, robot="g1"),
    Picture("press_romeo", "press", 3.0, robot="romeo"),
    Picture("sphere", "sphere", 5.0),
    Picture("two_arms", "two_arms", 2.5),
)


def main(words: Sequence[str] | None = None) -> None:
    """Make what is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=Path, default=Path("runs/gallery"))
    parser.add_argument("--to", type=Path, default=IMAGES)
    parser.add_argument("--small", action="store_true")
    asked = parser.parse_args(words)
    for one in PICTURES:
        if asked.small and one.name not in SMALL:
            continue
        run = run_of(one, asked.runs, ["duration=" + str(BRIEF)] if asked.small else [])
        path = asked.to / f"gallery_{one.name}.png"
        style = Style(size=SMALL_SIZE if asked.small else SIZE, camera=one.camera)
        print(write_still(run, path, SEEN if asked.small else one.t, style))
        if one.film and not asked.small:
            print(film(run, asked.to / f"{one.name}.gif", one.camera))


def run_of(picture: Picture, folder: Path, overrides: Sequence[str]) -> Run:
    """Return the run of a picture, from before if there is one."""
    place = folder / f"{picture.scenario}-{picture.robot or 'own'}"
    try:
        return load_run(place)
    except RunLogError:
        return run_scenario(
            picture.scenario, robot=picture.robot, out=place, overrides=overrides, figures=False
        )


def film(run: Run, path: Path, camera: str) -> Path:
    """Write a run as an animated GIF."""
    view = View(run, Style(size=FILM_SIZE, camera=camera))
    frames = []
    for t in np.arange(run.t[0], run.t[-1], 1.0 / FILM_RATE):
        frames.append(Image.fromarray(view.image(float(t))).quantize(COLOURS, RARE_TOO, dither=0))
    frames[0].save(
        path,
        save_all=True,
        append_images=frames[1:],
        duration=1000 // FILM_RATE,
        loop=0,
        optimize=True,
    )
    return path


if __name__ == "__main__":
    main()
