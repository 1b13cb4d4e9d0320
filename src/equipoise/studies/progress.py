"""What is shown while a study runs: how many runs are done and good, and how long it takes."""

from __future__ import annotations

import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn

from equipoise.studies.give_out import Standing

EVERY = 30.0  # [s] between two lines where there is no terminal


class StudyProgress:
    """A bar on a terminal, a line now and then elsewhere; call it with how far a study is."""

    def __init__(self) -> None:
        self._console = Console(highlight=False, soft_wrap=True)
        self._bar: Progress | None = None
        self._bar_task: TaskID | None = None
        self._told = -EVERY
        self.last: Standing | None = None
        self._began = time.monotonic()

    def __enter__(self) -> StudyProgress:
        if self._console.is_terminal:
            columns = (BarColumn(40), TextColumn("{task.description}"))
            self._bar = Progress(*columns, console=self._console)
            self._bar.start()
            self._bar_task = self._bar.add_task("starting workers", total=None)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        tb: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    @property
    def spent(self) -> float:
        """For how long [s] the study has run in this call."""
        return time.monotonic() - self._began

    def __call__(self, standing: Standing) -> None:
        if self.last is None and standing.before:
            self._console.print(f"{standing.before} runs were done before", markup=False)
        if standing == self.last:
            return
        ended = self.last is not None and self.last.done == standing.done == standing.most
        self.last = standing
        text = sentence(standing)
        if self._bar is not None and self._bar_task is not None:
            self._bar.update(
                self._bar_task, completed=standing.done, total=standing.most, description=text
            )
            return
        if ended:
            return
        if standing.done == standing.most or time.monotonic() - self._told >= EVERY:
            if standing.done > standing.before:
                self._console.print(text, markup=False)
            self._told = time.monotonic()


def sentence(standing: Standing) -> str:
    """Return how far a study is in a line."""
    left = "" if standing.left is None else f", {duration(standing.left)} left"
    slots = f"{standing.slots} worker{'s' * (standing.slots != 1)}"
    done = f"{standing.done} of {standing.most} runs"
    return f"{done}, {standing.good} good, {slots}{left if standing.done < standing.most else ''}"


def duration(seconds: float) -> str:
    """Return a time as a person says it."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = seconds / 60.0
    return f"{minutes:.0f} min" if minutes < 90.0 else f"{minutes / 60.0:.1f} h"
