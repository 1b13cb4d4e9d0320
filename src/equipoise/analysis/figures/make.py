"""All figures of a run, written as PNG files."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from equipoise.analysis.run_context import RunContext
from equipoise.errors import RunLogError
from equipoise.runlog import Run


def make_figures(run: Run, folder: Path | str) -> list[Path]:
    """Write every figure that the run has something to show for; return their paths.

    Names: joints.png, errors.png, torques.png, distances.png, balance.png, walk.png,
    snapshots.png. A
    figure whose channels are missing, or a run without ticks, gives none; neither does a figure
    of the robot where the run's scenario can no longer be read.

    Raises: RunLogError if the folder cannot be written.
    """
    return draw_figures(RunContext.of(run), Path(folder))


def draw_figures(
    context: RunContext, folder: Path, report: Callable[[float], None] | None = None
) -> list[Path]:
    """Do what `make_figures` does for a run whose context is there; `report` is told the share.

    Raises: RunLogError if the folder cannot be written.
    """
    from equipoise.analysis.figures.balance import balance_figure
    from equipoise.analysis.figures.distance import distances_figure
    from equipoise.analysis.figures.error import errors_figure
    from equipoise.analysis.figures.joints import joints_figure, torques_figure
    from equipoise.analysis.figures.snapshots import run_strip
    from equipoise.analysis.figures.style import save
    from equipoise.analysis.figures.walk import walk_figure

    makers = {
        "joints": joints_figure,
        "errors": errors_figure,
        "torques": torques_figure,
        "distances": distances_figure,
        "balance": balance_figure,
        "walk": walk_figure,
        "snapshots": run_strip,
    }
    paths = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for k, (name, make) in enumerate(makers.items()):
            with _uncollected():
                figure = make(context)
                if figure is not None:
                    paths.append(save(figure, folder / f"{name}.png"))
            if report is not None:
                report((k + 1) / len(makers))
    except OSError as error:
        raise RunLogError(f"Cannot write figures into {folder}: {error.strerror}.") from error
    return paths


@contextmanager
def _uncollected() -> Iterator[None]:
    """Keep the garbage collector still: it looks at a figure's thousands of parts in vain."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
