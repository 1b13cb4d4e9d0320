"""A run, or two side by side, as an MP4 film or a still, drawn by us and written by ffmpeg."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from equipoise.analysis.rendering.captions import write_caption
from equipoise.analysis.rendering.render import OUTDOORS, Renderer
from equipoise.analysis.rendering.run_pictures import RunPictures
from equipoise.analysis.rendering.shots import Shot, shot
from equipoise.analysis.run_context import RunContext
from equipoise.errors import EquipoiseError, InputError
from equipoise.optional import require_package
from equipoise.runlog import Run

SMALLEST, LARGEST = 64, 4096  # [pixels]


class NoVideoError(EquipoiseError):
    """A film cannot be made here; the message says what is missing."""


@dataclass(frozen=True)
class Style:
    """How a film looks: size [pixels], pictures a second, camera preset, and what is added.

    `speed` 2 shows a run in half its time. Raises: InputError.
    """

    size: tuple[int, int] = (960, 540)
    fps: int = 25
    camera: str = "quarter"
    speed: float = 1.0
    arrows: bool = True
    captions: bool = True

    def __post_init__(self) -> None:
        if not all(SMALLEST <= side <= LARGEST for side in self.size):
            raise InputError(
                f"a picture has {SMALLEST} to {LARGEST} pixels a side", given=self.size
            )
        if not 0.01 <= self.speed <= 100.0:
            raise InputError("the speed is a number from 0.01 to 100", given=self.speed)
        if not 1 <= self.fps <= 120:
            raise InputError("a film has 1 to 120 pictures a second", given=self.fps)


def write_video(
    runs: Run | Sequence[Run],
    path: Path,
    style: Style | None = None,
    *,
    report: Callable[[float], None] | None = None,
) -> Path:
    """Write a film of a run, or of several side by side, and return its path.

    `report` is told the share done. A run that ends before another stands still.
    Raises: `InputError` if a run cannot be shown or `path` can be no film, `NoVideoError` if
    writing fails here.
    """
    style = style or Style()
    if path.suffix.lower() != ".mp4" or path.is_dir():
        remedy = "Name a file that ends in .mp4"
        raise InputError("a film is one MP4 file", given=str(path), remedy=remedy)
    views = _views(runs, style)
    width, height = style.size
    wide = width * len(views)
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise NoVideoError(f"{error}; install it with: pip install 'equipoise[film]'") from None
    path.parent.mkdir(parents=True, exist_ok=True)
    first = min(view.run.t[0] for view in views)
    last = max(view.run.t[-1] for view in views)
    times = np.arange(first, last, style.speed / style.fps)
    writer = imageio_ffmpeg.write_frames(
        str(path), (wide, height), fps=style.fps, codec="libx264", quality=8, macro_block_size=2
    )
    try:
        writer.send(None)
        for k, t in enumerate(times):
            writer.send(np.hstack([view.image(float(t)) for view in views]).tobytes())
            if report is not None:
                report((k + 1) / len(times))
    except OSError as error:
        cause = str(error).splitlines()[0]
        raise NoVideoError(f"ffmpeg could not write {path} ({cause})") from error
    finally:
        writer.close()
    return path


def write_still(
    runs: Run | Sequence[Run], path: Path, t: float, style: Style | None = None
) -> Path:
    """Write the picture at time `t` [s] of a run, or of several side by side, as PNG.

    Raises: `InputError` if a run cannot be shown or the file not be written.
    """
    require_package("PIL", "plot", "a still")
    from PIL import Image

    if path.suffix.lower() != ".png" or path.is_dir():
        raise InputError("a still is a PNG file", given=str(path), remedy="Let it end in .png")
    image = np.hstack([view.image(t) for view in _views(runs, style or Style())])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(image).save(path, optimize=True)
    except OSError as error:
        raise InputError(f"Cannot write it: {error.strerror}", given=str(path)) from error
    return path


class View:
    """One run as a film shows it."""

    def __init__(self, run: Run, style: Style) -> None:
        if not run.t.size:
            raise InputError("a run without ticks has nothing to show", given=run.folder.name)
        context = RunContext.of(run)
        if not context.drawable:
            raise InputError(
                "there is nothing to draw",
                given=run.folder.name,
                remedy="Give a run whose scenario this version can read",
            )
        self.run, self._style = run, style
        self._pictures = RunPictures(context, arrows=style.arrows)
        width, height = style.size
        self._shot: Shot = shot(self._pictures, style.camera, width / height)
        self._renderer = Renderer(width, height, light=OUTDOORS)
        self._title = context.scenario.title or run.folder.name

    def image(self, t: float) -> np.ndarray:
        """Return the picture (height, width, 3) of bytes at time `t` [s]."""
        ticks = self._pictures.ticks
        tick = int(ticks[np.searchsorted(ticks, self.run.at(t)).clip(0, len(ticks) - 1)])
        drawn = self._renderer.image(self._pictures.at(tick), self._shot(tick))
        image = np.clip(np.round(255.0 * drawn), 0.0, 255.0).astype(np.uint8)
        if self._style.captions:
            shown = f"t = {self.run.t[tick]:.2f} s"
            if self._style.speed != 1.0:
                shown += f"   (speed {self._style.speed:g})"
            write_caption(image, self._title, shown, arrows=self._style.arrows)
        return image


def _views(runs: Run | Sequence[Run], style: Style) -> list[View]:
    return [View(run, style) for run in ([runs] if isinstance(runs, Run) else runs)]
