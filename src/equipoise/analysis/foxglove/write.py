"""Adding the pictures of a run to its log, and a layout beside it."""

from __future__ import annotations

from pathlib import Path

from equipoise.analysis.foxglove.layout import layout_text
from equipoise.analysis.foxglove.pictures import picture_topics
from equipoise.analysis.run_context import RunContext
from equipoise.errors import RunLogError
from equipoise.runlog.folders import LOG_NAME
from equipoise.runlog.topics import add_topics

LAYOUT_NAME = "foxglove_layout.json"


def add_pictures(context: RunContext, log: Path | None = None) -> Path:
    """Add pictures to the log of a run and write a layout beside it; return the log's path.

    `log` is another place of the same log.
    Raises: InputError if there is nothing to draw; RunLogError if the log is not whole or the disk
    refuses.
    """
    path = log or context.run.folder / LOG_NAME
    add_topics(path, picture_topics(context))
    layout = path.parent / LAYOUT_NAME
    try:
        layout.write_text(layout_text(context.run), encoding="utf-8")
    except OSError as error:
        raise RunLogError(f"Cannot write {layout}: {error.strerror}.") from error
    return path
