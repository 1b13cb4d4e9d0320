"""What `equipoise bench` does: measure, print, write, hold against kept results."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from equipoise.bench.compare import compare
from equipoise.bench.memory import measure_memory
from equipoise.bench.peers import parse_pythons
from equipoise.bench.print_tables import show_changes, show_ratios, show_rows
from equipoise.bench.problem import make_problem
from equipoise.bench.rows import read_rows, require_place, write_rows
from equipoise.bench.run import QUICK_TICKS, run_bench
from equipoise.bench.scaling import growth, linear_share
from equipoise.console import Progress

GROWTH_TICKS = 400


def bench_times(
    robots: Sequence[str],
    pythons: Sequence[str],
    *,
    quick: bool,
    grows: bool,
    to: Path | None,
    kept: Path | None,
) -> bool:
    """Measure and print; return whether every ratio holds against the `kept` ones, if given.

    Raises: `InputError`.
    """
    named = parse_pythons(pythons)
    before = read_rows(kept) if kept is not None else None
    if to is not None:
        require_place(to)
    with Progress() as progress:
        rows = run_bench(
            robots,
            ticks=QUICK_TICKS if quick else None,
            pythons=named,
            say=lambda sentence: click.echo(sentence, err=True),
            report=progress,
        )
        if grows:
            rows += growth(QUICK_TICKS if quick else GROWTH_TICKS, progress)
    if to is not None:
        write_rows(to, rows)
    show_rows(rows)
    show_ratios(rows)
    if grows:
        click.echo(f"time per further row, upper half over lower: {linear_share(rows):.2f}")
    if before is None:
        return True
    changes = compare(rows, before)
    show_changes(changes)
    return all(change.passed for change in changes)


def bench_memory(robots: Sequence[str], ticks: int) -> bool:
    """Run so many ticks on each robot; print and return whether memory stays."""
    passed = True
    for name in robots:
        with Progress() as progress:
            found = measure_memory(make_problem(name), ticks, progress)
        click.echo(f"{name}: {found}")
        passed = passed and found.passed
    return passed
