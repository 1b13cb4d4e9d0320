"""What `equipoise render` does: a film or a still of runs, as its options say."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from equipoise.analysis.rendering.video import Style, write_still, write_video
from equipoise.errors import InputError
from equipoise.runlog import Run


def render_runs(
    runs: Sequence[Run],
    to: Path | None,
    size: str,
    asked: Mapping[str, Any],
    report: Callable[[float], None] | None = None,
) -> Path:
    """Write a film of runs side by side, or with `asked["still"]` one picture; return its path.

    `size` is "WIDTHxHEIGHT" [pixels]; `asked` holds the other fields of `Style`.
    Raises: InputError, NoVideoError.
    """
    given = re.fullmatch(r"(\d{1,5})x(\d{1,5})", size)
    if given is None:
        raise InputError("a size is WIDTHxHEIGHT in pixels", given=size, remedy="--size 960x540")
    width, height = (2 * (int(side) // 2) for side in given.groups())  # ffmpeg wants even sides
    wanted = {name: value for name, value in asked.items() if name != "still"}
    style = Style(size=(width, height), **wanted)
    still = asked.get("still")
    if still is not None:
        return write_still(runs, to or runs[0].folder / "still.png", float(still), style)
    return write_video(runs, to or runs[0].folder / "video.mp4", style, report=report)
