"""All figures of a run, written as PNG files."""

from __future__ import annotations

from pathlib import Path

from equipoise.errors import RunLogError
from equipoise.runlog import Run


def make_figures(run: Run, folder: Path | str) -> list[Path]:
    """Write every figure that the run has something to show for; return their paths.

    Names: joints.png, errors.png, torques.png, distances.png, balance.png, snapshots.png. A
    figure whose channels are missing, or a run without ticks, gives none; neither does a figure
    of the robot where the run's scenario can no longer be read.

    Raises: RunLogError if the folder cannot be written.
    """
    from equipoise.analysis.figures.balance import balance_figure
    from equipoise.analysis.figures.distance import distances_figure
    from equipoise.analysis.figures.error import errors_figure
    from equipoise.analysis.figures.joints import joints_figure, torques_figure
    from equipoise.analysis.figures.snapshots import snapshot_strip
    from equipoise.analysis.figures.style import save
    from equipoise.analysis.run_context import RunContext

    context = RunContext.of(run)
    makers = {
        "joints": joints_figure,
        "errors": errors_figure,
        "torques": torques_figure,
        "distances": distances_figure,
        "balance": balance_figure,
    }
    folder = Path(folder)
    paths = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, make in makers.items():
            figure = make(context)
            if figure is not None:
                paths.append(save(figure, folder / f"{name}.png"))
        if context.drawable:
            strip = snapshot_strip(run, setup=context.setup)
            paths.append(save(strip, folder / "snapshots.png"))
    except OSError as error:
        raise RunLogError(f"Cannot write figures into {folder}: {error.strerror}.") from error
    return paths
