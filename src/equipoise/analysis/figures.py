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
    from equipoise.analysis.balance_figure import balance_figure
    from equipoise.analysis.distance_figure import distances_figure
    from equipoise.analysis.error_figure import errors_figure
    from equipoise.analysis.joint_figures import joints_figure, torques_figure
    from equipoise.analysis.snapshots import snapshot_strip
    from equipoise.analysis.story import Story
    from equipoise.analysis.style import save

    story = Story.of(run)
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
            figure = make(story)
            if figure is not None:
                paths.append(save(figure, folder / f"{name}.png"))
        if story.drawable:
            strip = snapshot_strip(run, places=story.places)
            paths.append(save(strip, folder / "snapshots.png"))
    except OSError as error:
        raise RunLogError(f"Cannot write figures into {folder}: {error.strerror}.") from error
    return paths
