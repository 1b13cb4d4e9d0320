"""The table of `equipoise verify`: a line a row while it runs, a summary, JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence

from rich.console import Console

from equipoise.verify.row import Verdict

_console = Console(highlight=False, soft_wrap=True)


def print_verdict(verdict: Verdict) -> None:
    """Print a row: what was checked, the residual, the tolerance, where it is in the code."""
    check, measured = verdict.check, verdict.measured
    mark = "[green]holds[/]" if verdict.holds else "[red bold]FAILS[/]"
    numbers = f"{measured.residual:>9.2g} <= {check.tolerance:<7.2g} {check.unit}"
    _console.print(f"{mark} {check.key:<16} {numbers:<38} {check.claim}")
    _console.print(f"      [dim]{check.code}. {_escaped(measured.note)}[/]")


def print_verdicts(verdicts: Sequence[Verdict]) -> None:
    """Print how many rows hold, and which do not."""
    broken = [verdict.check.key for verdict in verdicts if not verdict.holds]
    seconds = sum(verdict.seconds for verdict in verdicts)
    _console.print(f"{len(verdicts) - len(broken)} of {len(verdicts)} rows hold ({seconds:.0f} s).")
    if broken:
        _console.print(f"[red bold]Not: {', '.join(broken)}[/]")


def as_text(verdicts: Sequence[Verdict]) -> str:
    """Return the table as JSON."""
    document = {
        "holds": all(verdict.holds for verdict in verdicts),
        "rows": [verdict.as_dict() for verdict in verdicts],
    }
    return json.dumps(document, indent=2, allow_nan=False)


def _escaped(text: str) -> str:
    return text.replace("[", "\\[")
