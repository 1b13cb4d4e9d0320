"""Write the tables of docs/benchmarks.md from the kept results in benchmarks/tray.json."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from equipoise.bench import Row, read_rows
from equipoise.bench.compare import ratios

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "benchmarks" / "tray.json"
PAGE = ROOT / "docs" / "benchmarks.md"
WHAT = {
    "dof": "unknowns-robot, motion",
    "tasks": "frame tasks on one level, motion",
    "levels": "levels of eight frame tasks, motion",
    "contacts": "flat contacts, law",
    "pairs": "collision pairs, motion of the tray",
    "rows": "inactive inequality rows, hierarchy alone",
    "unknowns": "unknowns, hierarchy alone",
}


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    cells = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in cells)


def times(rows: Sequence[Row]) -> str:
    """Return median and tail of everything but growth."""
    found = [row for row in rows if not row.name.startswith("growth/")]
    return table(
        ("row", "median [µs]", "p99 [µs]", "failed", ""),
        [
            (
                f"`{row.name}`",
                f"{row.median_us:.0f}",
                f"{row.p99_us:.0f}",
                f"{row.failures} of {row.ticks}",
                row.remark,
            )
            for row in found
        ],
    )


def shares(rows: Sequence[Row]) -> str:
    """Return our medians over those of the peers, and over DAQP's."""
    chosen = [r for r in ratios(rows) if r.ours.startswith("hqp/") or r.other.startswith("peer/")]
    return table(
        ("ours", "over", "ratio"),
        [(f"`{r.ours}`", f"`{r.other}`", f"{r.value:.2f}") for r in chosen],
    )


def growths(rows: Sequence[Row]) -> str:
    """Return each table of growth in one line: size: median."""
    lines = []
    for key, words in WHAT.items():
        found = [row for row in rows if row.name.startswith(f"growth/{key}/")]
        sizes = [f"{row.name.rsplit('/', 1)[1]}: {row.median_us:.0f}" for row in found]
        lines.append((words, ", ".join(sizes)))
    return table(("grows with", "size: median [µs]"), lines)


def filled(text: str, rows: Sequence[Row]) -> str:
    """Return the page's text with its tables written anew."""
    for name, make in (("times", times), ("ratios", shares), ("growth", growths)):
        pattern = rf"(<!-- measured:{name} -->\n).*?(<!-- /measured:{name} -->)"
        new = make(rows) + "\n"
        text = re.sub(pattern, lambda m, new=new: m[1] + new + m[2], text, flags=re.DOTALL)
    return text


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), read_rows(KEPT)), encoding="utf-8")
