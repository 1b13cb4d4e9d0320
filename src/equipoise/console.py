"""What the command line shows: progress while it works, tables when it is done."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from pathlib import Path
from types import TracebackType
from typing import Any

from rich.console import Console, JustifyMethod
from rich.markup import escape
from rich.progress import BarColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as RichProgress
from rich.table import Table

from equipoise.robots import Robot

WORTH_SAYING = 1.0  # [s] of loading kernels
TOLD_AT_MOST = 8

_console = Console(highlight=False, soft_wrap=True)


class Progress:
    """A bar a stage; call it with the stage and its share in [0, 1].

    A share of None is work in between whose end nobody knows: its bar only moves.
    """

    def __init__(self) -> None:
        self._bars: RichProgress | None = None
        self._tasks: dict[str, TaskID] = {}
        self._stage = ""

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        tb: TracebackType | None,
    ) -> None:
        self.rest(finished=kind is None)

    def __call__(self, stage: str, share: float | None) -> None:
        bars = self._bars or self._open()
        if stage not in self._tasks:
            self._tasks[stage] = bars.add_task(stage, total=1.0, share="")
        if share is None:
            bars.update(self._tasks[stage], total=None, share="")
            return
        if stage != self._stage:
            self._finish(but=stage)
            self._stage = stage
        self._show(stage, share)

    def tell(self, sentence: str) -> None:
        """Print a sentence between the bars."""
        self.rest()
        _console.print(f"Told:    {sentence}", markup=False)

    def rest(self, *, finished: bool = True) -> None:
        """Leave the bars as they stand; the next stage opens new ones below."""
        if self._bars is not None:
            if finished:
                self._finish()
            self._bars.stop()
        self._bars, self._tasks, self._stage = None, {}, ""

    def _open(self) -> RichProgress:
        self._bars = RichProgress(
            TextColumn("{task.description:<18}"),
            BarColumn(40),
            TextColumn("{task.fields[share]:>5}"),
            TimeElapsedColumn(),
            console=_console,
        )
        self._bars.start()
        return self._bars

    def _finish(self, but: str = "") -> None:
        for stage in self._tasks:
            if stage != but:
                self._show(stage, 1.0)

    def _show(self, stage: str, share: float) -> None:
        if self._bars is not None:
            text = f"{100.0 * share:.0f} %"
            self._bars.update(self._tasks[stage], completed=share, total=1.0, share=text)


def print_summary(summary: Mapping[str, Any], folder: Path) -> None:
    """Print wanted against achieved, the speed, and where everything is."""
    table = Table(title=escape(f"{summary['title'] or summary['scenario']} ({summary['robot']})"))
    columns: list[tuple[str, JustifyMethod]] = [
        ("", "left"), ("achieved", "right"), ("wanted", "right"), ("", "left"),
    ]  # fmt: skip
    for column, justify in columns:
        table.add_column(column, justify=justify)
    for row in summary["metrics"].values():
        mark = {True: "[green]yes", False: "[red bold]NO"}.get(row.get("passed"), "")
        table.add_row(escape(row["doc"]), _quantity(row["value"], row["unit"]), _wanted(row), mark)
    _console.print(table)
    timing = summary["timing"]
    first = timing["first_wall"]
    running = timing["wall"] - first
    speed = timing["t_end"] / running if running > 0.0 else float("nan")
    kernels = f", after {first:.1f} s for loading the kernels" if first > WORTH_SAYING else ""
    _console.print(
        f"{timing['t_end']:.2f} s simulated in {running:.2f} s{kernels} "
        f"({speed:.1f} times real time); tick {timing['tick_us'][0]:.0f} us, "
        f"physics {timing['physics_us'][0]:.0f} us (medians)"
    )
    for line in _story(summary):
        _console.print(line, markup=False)
    if summary["ended"] != "completed":
        _console.print(f"[red bold]Ended early:[/] {escape(str(summary['note']))}")
    _print_faults(summary)
    _console.print(f"Result: {'[green]met' if summary['passed'] else '[red bold]not met'}[/]")
    _console.print(f"Run:     {folder}", markup=False)


def _print_faults(summary: Mapping[str, Any]) -> None:
    """Print what happened that cannot be, and where it can be looked at."""
    for fault in summary.get("impossible") or ():
        _console.print(f"[red bold]Impossible:[/] {escape(fault)}")
    if summary.get("look"):
        _console.print(f"Look at:  {summary['look']}", markup=False)


def print_figures(folder: Path) -> None:
    """Print where the figures of a run are, if there are any."""
    if (folder / "figures").is_dir():
        _console.print(f"Figures: {folder / 'figures'}", markup=False)


def _story(summary: Mapping[str, Any]) -> list[str]:
    """Return what happened during the run in lines, and why a metric may be undefined."""
    changes = list(summary.get("changes") or ())
    lines = [f"Told:    {change}" for change in changes[:TOLD_AT_MOST]]
    if len(changes) > TOLD_AT_MOST:
        lines.append(f"         and {len(changes) - TOLD_AT_MOST} more in summary.json")
    rows = summary["metrics"].values()
    if any(row["value"] in (inf, "inf", None) and "settled" in row["doc"] for row in rows):
        lines.append("inf:     no tick to judge by; what is settled begins at acceptance.after")
    return lines


def print_robots(robots: Mapping[str, Any]) -> None:
    """Print the named robots, one a line."""
    for name, robot in robots.items():
        missing = f" (not installed: {robot.missing})" if robot.missing else ""
        _console.print(f"{name:<16}{robot.summary}{missing}", markup=False)


def print_robot(robot: Robot) -> None:
    """Print sizes, frames and joint limits of a robot."""
    frames = [name for name in robot.frame_names if name not in robot.joint_names]
    for line in (
        f"{robot.name}: {robot.na} actuated joints, {robot.mass:.2f} kg",
        f"file:   {robot.urdf_path}",
        f"base:   {robot.base.kind}",
        f"soles:  {', '.join(s.frame for s in robot.soles) or 'none'}",
        f"feet:   {', '.join(f.frame for f in robot.feet) or 'none'}",
        f"palms:  {', '.join(p.frame for p in robot.palms) or 'none'}",
        f"camera: {robot.camera or 'none'}",
        f"frames: {', '.join(frames)}",
    ):
        _console.print(line, markup=False)
    table = Table()
    for column in ("joint", "lower [rad]", "upper [rad]", "speed [rad/s]", "torque [N m]"):
        table.add_column(escape(column), justify="left" if column == "joint" else "right")
    for i, joint in enumerate(robot.joint_names):
        limits = (robot.q_min[i], robot.q_max[i], robot.v_max[i], robot.tau_max[i])
        table.add_row(escape(joint), *(f"{x:.3f}" for x in limits))
    _console.print(table)


def _quantity(value: Any, unit: str) -> str:
    if value is None:
        return "-"
    number = float(value)
    scale, shown = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}.get(unit, (1.0, unit))
    return f"{number * scale:.4g} {shown}".rstrip()


def _wanted(row: Mapping[str, Any]) -> str:
    signs = {"max": "<=", "min": ">="}
    bounds, always = row.get("wanted", {}), row.get("loosened", {})
    wanted = ", ".join(f"{signs[k]} {_quantity(bounds[k], row['unit'])}" for k in bounds)
    if always:
        usual = ", ".join(f"{signs[k]} {_quantity(always[k], row['unit'])}" for k in always)
        wanted += f" (loosened from {usual})"
    return wanted
