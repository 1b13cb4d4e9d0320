"""Write the measured parts of docs/walking.md from what benchmarks/walking*.py kept."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "benchmarks" / "walking.jsonl"
TICKS = ROOT / "benchmarks" / "walking_tick.json"
PAGE = ROOT / "docs" / "walking.md"
ROBOTS = {"hrp2": "HRP-2", "talos": "TALOS", "g1": "G1"}


def cell(row: dict[str, Any] | None) -> str:
    """Return base and joints of a run, and what else is worth telling."""
    if row is None:
        return ""
    if row["ended"] != "completed":
        return "falls" if row["ended"].startswith("fell") else row["ended"]
    words = f"{row['base']:.2f}, {row['joints']:.3g}"
    if row["back"] is not None:
        words += f"; back after {row['back']:.1f} s"
    return words


def results(rows: Sequence[dict[str, Any]]) -> str:
    """Return the table of every case on every robot."""
    found = {(row["case"], row["robot"]): row for row in rows}
    cases = list(dict.fromkeys(row["case"] for row in rows))
    lines = ["| case | " + " | ".join(ROBOTS.values()) + " |", "| --- | --- | --- | --- |"]
    for case in cases:
        cells = (cell(found.get((case, robot))) for robot in ROBOTS)
        lines.append(f"| {case} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def ticks(rows: Sequence[dict[str, Any]]) -> str:
    """Return the table of what a tick takes."""
    walk, tray = (row["median_us"] for row in rows)
    return "\n".join([
        "| tick in MuJoCo, median | walk | tray | ratio, wanted <= 1.3 |",
        "| --- | --- | --- | --- |",
        f"| `python benchmarks/walking_tick.py` | {walk:.0f} µs | {tray:.0f} µs "
        f"| {walk / tray:.2f} |",
    ])  # fmt: skip


def filled(text: str, rows: Sequence[dict[str, Any]], timed: Sequence[dict[str, Any]]) -> str:
    """Return the page's text with what was measured written anew."""
    for name, new in (("walking", results(rows)), ("tick", ticks(timed))):
        pattern = rf"(<!-- measured:{name} -->\n).*?(<!-- /measured:{name} -->)"
        text = re.sub(pattern, lambda m, new=new: f"{m[1]}{new}\n{m[2]}", text, flags=re.DOTALL)
    return text


def page() -> str:
    """Return the page as it is to be."""
    kept = [json.loads(line) for line in KEPT.read_text(encoding="utf-8").splitlines()]
    timed = json.loads(TICKS.read_text(encoding="utf-8"))
    return filled(PAGE.read_text(encoding="utf-8"), kept, timed)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
