"""What the command line shows: progress while it works, tables when it is done."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from pathlib import Path
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as RichProgress
from rich.table import Table

from equipoise.robots import Robot

WORTH_SAYING = 1.0  # [s] of loading kernels
TOLD_AT_MOST = 8

_console = Console(highlight=False, soft_wrap=True)


class Progress:
    """A bar a stage; call it with the stage and its share in [0, 1]."""

    def __init__(self) -> None:
        self._bars = RichProgress(
            TextColumn("{task.description:<18}"),
            BarColumn(40),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            console=_console,
        )
        self._task: TaskID | None = None
        self._stage = ""

    def __enter__(self) -> Progress:
        self._bars.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        tb: TracebackType | None,
    ) -> None:
        if kind is None:
            self._finish()
        self._bars.stop()

    def __call__(self, stage: str, share: float) -> None:
        if stage != self._stage:
            self._finish()
            self._stage = stage
            self._task = self._bars.add_task(stage, total=1.0)
        if self._task is not None:
            self._bars.update(self._task, completed=share)

    def _finish(self) -> None:
        if self._task is not None:
            self._bars.update(self._task, completed=1.0)


def print_summary(summary: Mapping[str, Any], folder: Path) -> None:
    """Print wanted against achieved, the speed, and where everything is."""
    table = Table(title=f"{summary['title'] or summary['scenario']} ({summary['robot']})")
    for column, justify in (("", "left"), ("achieved", "right"), ("wanted", "right"), ("", "left")):
        table.add_column(column, justify=justify)
    for row in summary["metrics"].values():
        mark = {True: "[green]yes", False: "[red bold]NO"}.get(row.get("passed"), "")
        table.add_row(row["doc"], _quantity(row["value"], row["unit"]), _wanted(row), mark)
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
        _console.print(f"[red bold]Ended early:[/] {summary['note']}")
    _console.print(f"Result: {'[green]met' if summary['passed'] else '[red bold]not met'}[/]")
    _console.print(f"Run:     {folder}")
    if (folder / "figures").is_dir():
        _console.print(f"Figures: {folder / 'figures'}")


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
        f"URDF:   {robot.urdf_path}",
        f"soles:  {', '.join(s.frame for s in robot.soles) or 'none'}",
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
        table.add_row(joint, *(f"{x:.3f}" for x in limits))
    _console.print(table)


def _quantity(value: Any, unit: str) -> str:
    if value is None:
        return "-"
    number = float(value)
    scale, shown = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}.get(unit, (1.0, unit))
    return f"{number * scale:.4g} {shown}".rstrip()


def _wanted(row: Mapping[str, Any]) -> str:
    signs = {"max": "<=", "min": ">="}
    bounds = row.get("wanted", {})
    return ", ".join(f"{signs[k]} {_quantity(bounds[k], row['unit'])}" for k in bounds)
