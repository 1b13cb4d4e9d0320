"""Write the tables of docs/walking.md from the kept results in benchmarks/walking.jsonl."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "benchmarks" / "walking.jsonl"
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


def filled(text: str, rows: Sequence[dict[str, Any]]) -> str:
    """Return the page's text with its table written anew."""
    pattern = r"(<!-- measured:walking -->\n).*?(<!-- /measured:walking -->)"
    new = results(rows) + "\n"
    return re.sub(pattern, lambda m: m[1] + new + m[2], text, flags=re.DOTALL)


if __name__ == "__main__":
    kept = [json.loads(line) for line in KEPT.read_text(encoding="utf-8").splitlines()]
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), kept), encoding="utf-8")
