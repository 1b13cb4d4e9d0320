"""Where a film's camera stands: presets that show the whole run, the hands, or go along."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from equipoise.analysis.rendering.camera import Camera
from equipoise.analysis.rendering.run_pictures import RunPictures
from equipoise.errors import NameNotFoundError
from equipoise.spatial import Array

Shot = Callable[[int], Camera]  # from a tick to the camera that sees it

# azimuth and elevation [deg] of each preset, as `Camera.around` takes them
ANGLES = {
    "quarter": (-40.0, 12.0),
    "front": (0.0, 8.0),
    "side": (-90.0, 7.0),
    "hands": (-28.0, 30.0),
    "follow": (-40.0, 12.0),
}
DISTANCE = 5.0  # [m] from the eye to what it looks at: far enough that little is bent
LOOKED_AT = 9  # ticks that a preset looks at to show all of a run
HANDS = 0.55  # [m] half the height of what is shown around the hands
STEADY = 0.35  # [s] over which the camera that follows is smoothed
AROUND = 0.08  # of the picture that stays free around the robot, for the words too
REACH = 0.8  # [m] of what surrounds the robot that a picture shows


def shot(pictures: RunPictures, preset: str, aspect: float) -> Shot:
    """Return the camera of a preset for a run; `aspect` is width over height of the picture.

    Raises: NameNotFoundError.
    """
    if preset not in ANGLES:
        raise NameNotFoundError("camera", preset, tuple(ANGLES))
    ticks = pictures.ticks[np.linspace(0, len(pictures.ticks) - 1, LOOKED_AT).astype(int)]
    points = [pictures.robot_points(int(tick)) for tick in np.unique(ticks)]
    points[0] = np.vstack([points[0], _surroundings(pictures, np.vstack(points))])
    azimuth, elevation = np.radians(ANGLES[preset])
    if preset == "hands":
        return _on_hands(pictures, azimuth, elevation, aspect)
    together = np.vstack(points)
    centre = 0.5 * (together.min(axis=0) + together.max(axis=0))
    still = Camera.around(centre, azimuth, elevation, DISTANCE)
    if preset != "follow":
        camera = _with_aspect(still.fitted(together, margin=AROUND), aspect)
        return lambda tick: camera
    window = _with_aspect(still.fitted(points[0], margin=2.0 * AROUND), aspect).window
    base = pictures.run["q"][:, :2] if pictures.setup.robot.nq_base == 7 else None
    return _following(pictures, replace(still, window=window), base)


def _surroundings(pictures: RunPictures, robot: Array) -> Array:
    """Return corners (n, 3) of what stands still, as far as it is near the robot's own."""
    still = pictures.still_points()
    low, high = robot.min(axis=0), robot.max(axis=0)
    near = np.clip(still, low - REACH, high + REACH)
    near[:, 2] = np.maximum(near[:, 2], 0.0)
    return near


def _on_hands(pictures: RunPictures, azimuth: float, elevation: float, aspect: float) -> Shot:
    frames = [palm.frame for palm in pictures.setup.robot.palms]
    window = (-HANDS * aspect, HANDS * aspect, -HANDS, HANDS)

    def middle(tick: int) -> Array:
        kin = pictures.kinematics(tick)
        if not frames:
            return pictures.robot_points(tick).mean(axis=0)
        places = [kin.placement(pictures.setup.robot.frame_id(one)).translation for one in frames]
        return np.mean(places, axis=0)

    steady = _steady(pictures, middle)
    return lambda tick: replace(
        Camera.around(steady(tick), azimuth, elevation, DISTANCE), window=window
    )


def _following(pictures: RunPictures, camera: Camera, base: Array | None) -> Shot:
    if base is None:
        return lambda tick: camera
    start = np.array(base[pictures.ticks[0]])

    def middle(tick: int) -> Array:
        return np.array([*(base[tick] - start), 0.0])

    steady = _steady(pictures, middle)

    def at(tick: int) -> Camera:
        shift = steady(tick)
        return replace(camera, eye=camera.eye + shift, target=camera.target + shift)

    return at


def _steady(pictures: RunPictures, middle: Callable[[int], Array]) -> Callable[[int], Array]:
    """Return a place that goes along smoothly: the mean over `STEADY` around each moment."""
    t = pictures.run.t
    known = pictures.ticks[np.linspace(0, len(pictures.ticks) - 1, 120).astype(int)]
    known = np.unique(known)
    times, places = t[known], np.array([middle(int(tick)) for tick in known])

    def at(tick: int) -> Array:
        weight = np.exp(-0.5 * ((times - t[tick]) / STEADY) ** 2) + 1e-300
        return weight @ places / weight.sum()

    return at


def _with_aspect(camera: Camera, aspect: float) -> Camera:
    """Return the camera with a window of this width over height, around all it showed."""
    x_min, x_max, y_min, y_max = camera.window
    width = max(x_max - x_min, (y_max - y_min) * aspect)
    height, x, y = width / aspect, 0.5 * (x_min + x_max), 0.5 * (y_min + y_max)
    window = (x - width / 2, x + width / 2, y - height / 2, y + height / 2)
    return replace(camera, window=window)


def presets() -> Sequence[str]:
    """Return the names of all presets."""
    return tuple(ANGLES)
