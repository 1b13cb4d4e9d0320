"""Write the measured parts of docs/walking.md from what benchmarks/walking*.py kept."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "benchmarks" / "walking.jsonl"
TICKS = ROOT / "benchmarks" / "walking_tick.json"
PAGE = ROOT / "docs" / "walking.md"
ROBOTS = {"hrp2": "HRP-2", "talos": "TALOS", "g1": "G1"}


@dataclass(frozen=True)
class Wanted:
    """What a case is to show: base [mm] and joints [mrad] at most, and back within `back` [s]."""

    base: float = math.inf
    joints: float = math.inf
    back: float = math.inf

    def __str__(self) -> str:
        words = []
        if self.base < math.inf:
            words.append(f"base <= {self.base:g}")
        if self.joints < math.inf:
            words.append(f"joints <= {self.joints:g}")
        if self.back < math.inf:
            words.append(f"back within {self.back:g} s")
        return ", ".join(words) or "walks"

    def is_met(self, row: dict[str, Any]) -> bool:
        """Return whether a run shows it."""
        stands = row["ended"] == "completed" and (row["back"] or 0.0) <= self.back
        return stands and row["base"] <= self.base and row["joints"] <= self.joints


# by case; what one robot alone is asked stands in OWN
WANTED = {
    "walk": Wanted(2, 15), "walk, rigid": Wanted(2, 8), "slow steps": Wanted(10),
    "slow steps, rigid": Wanted(1, 5), "12 steps": Wanted(5), "0.4/0.15 s": Wanted(3, 25),
    "masses x 1.3": Wanted(12), "masses x 0.7": Wanted(12), "friction 0.4": Wanted(12),
    "5 kg in a hand": Wanted(12), "plank 2 cm": Wanted(12), "delay 3 ms": Wanted(3),
    "delay 5 ms": Wanted(3), "noise": Wanted(), "push 60 N forward": Wanted(back=2),
    "push 30 N to the left": Wanted(back=2), "push 30 N to the right": Wanted(back=2),
}  # fmt: skip
OWN = {("0.4/0.15 s", "g1"): Wanted(3, 60)}
CALM = ("walk", "slow steps", "12 steps", "0.4/0.15 s", "walk, rigid", "slow steps, rigid")
NOT_ASKED = {("delay 5 ms", "talos"), ("delay 5 ms", "g1")}


def cell(row: dict[str, Any] | None, wanted: Wanted | None) -> str:
    """Return base and joints of a run, and what else is worth telling."""
    if row is None:
        return ""
    if row["ended"] != "completed":
        words = "falls" if row["ended"].startswith("fell") else row["ended"]
    else:
        words = f"{row['base']:.2f}, {row['joints']:.3g}"
        if row["back"]:
            words += f"; back after {row['back']:.1f} s"
    return words if wanted is None or wanted.is_met(row) else f"**{words}**"


def results(rows: Sequence[dict[str, Any]]) -> str:
    """Return the table of every case on every robot; what is not met is bold."""
    found = {(row["case"], row["robot"]): row for row in rows}
    cases = list(dict.fromkeys(row["case"] for row in rows))
    lines = ["| case | wanted | " + " | ".join(ROBOTS.values()) + " |", "|" + " --- |" * 5]
    for case in cases:
        cells = []
        for robot in ROBOTS:
            wanted = OWN.get((case, robot), WANTED.get(case))
            asked = None if (case, robot) in NOT_ASKED else wanted
            cells.append(cell(found.get((case, robot)), asked))
        said = str(WANTED[case]) if case in WANTED else "-"
        lines.append(f"| {case} | {said} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def feet(rows: Sequence[dict[str, Any]]) -> str:
    """Return the table of torque jumps and centres of pressure of walks that nothing disturbs."""
    found = {(row["case"], row["robot"]): row for row in rows}
    lines = ["| | " + " | ".join(ROBOTS.values()) + " |", "|" + " --- |" * 4]
    for case in (case for case in CALM if any((case, robot) in found for robot in ROBOTS)):
        cells = []
        for robot in ROBOTS:
            row = found.get((case, robot))
            cells.append("" if row is None else f"{row['jump']:.0e}, {row['cop']:.1f}")
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
    blocks = {"walking": results(rows), "feet": feet(rows), "tick": ticks(timed)}
    for name, new in blocks.items():
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
