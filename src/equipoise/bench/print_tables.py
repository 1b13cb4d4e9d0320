"""What the bench prints: times, ratios, and what each peer leaves out."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from equipoise.bench.compare import Change, ratios
from equipoise.bench.peers import PEERS
from equipoise.bench.rows import Row

_console = Console(highlight=False, soft_wrap=True)


def show_rows(rows: Sequence[Row]) -> None:
    """Print the times of all rows."""
    table = Table(title="times of a tick [us]")
    table.add_column("name", no_wrap=True)
    for column in ("median", "p99", "ticks", "failed"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("")
    for row in rows:
        times = (f"{row.median_us:.1f}", f"{row.p99_us:.1f}", str(row.ticks), str(row.failures))
        table.add_row(row.name, *times, row.remark)
    _console.print(table)


def show_ratios(rows: Sequence[Row]) -> None:
    """Print our medians over those of others, and what the peers leave out of our tick."""
    chosen = [r for r in ratios(rows) if r.ours.startswith("hqp/") or r.other.startswith("peer/")]
    if not chosen:
        return
    table = Table(title="our median over the other's, same run: less is better")
    for column in ("ours", "the other's", "ratio", "what the other leaves out"):
        table.add_column(column, no_wrap=not column.startswith("what"))
    for ratio in chosen:
        peer = PEERS.get(ratio.other.split("/")[1])
        left_out = peer.leaves_out if peer is not None else "true squares where a level falls short"
        table.add_row(ratio.ours, ratio.other, f"{ratio.value:.3f}", left_out)
    _console.print(table)


def show_changes(changes: Sequence[Change]) -> None:
    """Print every ratio against the kept one, the worse ones last."""
    for change in sorted(changes, key=lambda change: change.passed, reverse=True):
        _console.print(str(change), markup=False)
