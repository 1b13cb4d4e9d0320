"""Run what the pages report, and write the tables between their `measured` comments.

`python docs/measure.py` does all of it, some ten minutes; with names of blocks only these. Runs
that are there already are not repeated: remove the folder `runs/measured` for fresh ones.
"""

from __future__ import annotations

import contextlib
import io
import math
import re
import runpy
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from equipoise import load_run, run_scenario
from equipoise.runlog import Run
from equipoise.scenarios import named_scenarios

ROOT = Path(__file__).parents[1]
RUNS = ROOT / "runs" / "measured"
LOW = "world.objects.tray.waypoints.4.xyz=[0.52,0,0.845]"
LOAD = "disturbances.payloads=[{mass: 5.0, object: tray}]"
SIGNS = {"max": "≤", "min": "≥"}


def run_of(label: str, scenario: str, *overrides: str) -> Run:
    """Return the run of that label, made now unless it is there."""
    folder = RUNS / label
    if not (folder / "summary.json").exists():
        print(f"running {label} ...", flush=True)
        shutil.rmtree(folder, ignore_errors=True)  # what an interrupted run left
        run_scenario(scenario, out=folder, overrides=overrides, figures=False)
    return load_run(folder)


def number(value: Any, unit: str) -> str:
    """Return a value with its unit, three digits, lengths in mm."""
    value = float(value)
    if not math.isfinite(value):
        return "impossible" if value < 0.0 else "infinite"
    scale, shown = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}.get(unit, (1.0, unit))
    value *= scale
    text = f"{value:.2g}" if abs(value) < 10.0 else f"{value:.0f}"
    return f"{text} {shown}".rstrip()


def value(run: Run, metric: str) -> float:
    """Return a metric of a run."""
    return float(run.summary["metrics"][metric]["value"])


def shown(run: Run, metric: str) -> str:
    """Return a metric of a run with its unit."""
    row = run.summary["metrics"][metric]
    return number(row["value"], row["unit"])


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    cells = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in cells)


def acceptance(label: str, scenario: str) -> str:
    """Return wanted and achieved for every row of a scenario's acceptance."""
    rows = []
    for name, row in run_of(label, scenario).summary["metrics"].items():
        if "wanted" in row and name != "completed":
            bounds = row["wanted"].items()
            wanted = ", ".join(f"{SIGNS[side]} {number(b, row['unit'])}" for side, b in bounds)
            for side, bound in row.get("loosened", {}).items():
                wanted += f" (loosened from {SIGNS[side]} {number(bound, row['unit'])})"
            met = "" if row["passed"] else " **(missed)**"
            doc = row["doc"].replace("|", "\\|")
            rows.append((doc, wanted, number(row["value"], row["unit"]) + met))
    return table(("", "wanted", "achieved"), rows)


def tray() -> str:
    """Return the tray's table."""
    return acceptance("tray", "tray")


def disturbances() -> str:
    """Return what happens to the tray when the controller is not told something."""
    cases = {
        "none": run_of("tray", "tray"),
        "all masses and inertias +30 %": run_of("heavy", "tray", "disturbances.mass_scale=1.3"),
        "all masses and inertias -30 %": run_of("light", "tray", "disturbances.mass_scale=0.7"),
        "5 kg on the tray from t = 0": run_of("load", "tray", LOAD),
    }
    rows = []
    for name, run in cases.items():
        margins = [run[c][:, 2] for c in run.names if c.startswith("margin/")]
        outside = sum(min(m[k] for m in margins) < 0.0 for k in range(len(run.t)))
        rows.append(
            (
                name,
                shown(run, "palm_position_worst"),
                shown(run, "palm_position_end"),
                shown(run, "force_error_rms"),
                shown(run, "torque_share"),
                shown(run, "reaction_pressure"),
                f"{outside} of {len(run.t)}",
            )
        )
    head = ("not told", "palms at worst", "palms at the end", "squeeze, RMS", "torque share")
    return table((*head, "room of the centre of pressure", "ticks outside the sole"), rows)


def priorities() -> str:
    """Return what each order does with a contradiction and without."""
    runs = [
        run_of("low", "tray", LOW),
        run_of("low_limits_first", "tray_limits_first", LOW),
        run_of("tray", "tray"),
        run_of("limits_first", "tray_limits_first"),
    ]
    metrics = {
        "palms from their target at the end": "palm_position_end",
        "palms from their target at worst, settled": "palm_position_error",
        "intrusion into the security distance": "security_shortfall",
        "least distance (negative: inside each other)": "clearance",
        "largest share of a speed limit": "velocity_share",
        "largest share of a torque limit": "torque_share",
        "ticks with a clamped torque": "saturated_ticks",
        "squeeze force error, RMS": "force_error_rms",
        "least normal force at a sole": "reaction_normal",
    }
    rows = [(name, *(shown(run, metric) for run in runs)) for name, metric in metrics.items()]
    head = ("paper's order, too low", "limits first, too low", "paper's order", "limits first")
    return table(("", *head), rows)


def solvers() -> str:
    """Return the certificates of each solver on the tray's hierarchies."""
    example = runpy.run_path(str(ROOT / "examples" / "06_solvers_side_by_side.py"))
    without_feet = ("tasks.left_foot.enabled=false", "tasks.right_foot.enabled=false")
    cases = {"as shipped": (), "without the foot tasks": without_feet}
    rows = []
    for title, overrides in cases.items():
        print(f"comparing solvers, {title} ...", flush=True)
        with contextlib.redirect_stdout(io.StringIO()):
            outcomes = example["main"](6.2, 10, *overrides)
        for name, o in outcomes.items():
            near = sum(excess <= 1e-8 for excess in o.excess)
            cells = (title, f"`{name}`", f"{o.holds} of {len(o.excess)}", f"{near}")
            rows.append((*cells, f"{max(o.excess):.1e}", f"{o.median_us:.0f} µs"))
    head = ("tasks", "solver", "certificates hold", "excess ≤ 1e-8", "worst excess")
    return table((*head, "median time"), rows)


def daqp_run() -> str:
    """Return the tray in closed loop under two solvers."""
    runs = run_of("tray", "tray"), run_of("daqp", "tray", "control.solver=daqp")
    metrics = ("palm_position_error", "posture_error", "force_error_rms", "clearance")
    metrics += ("velocity_share", "torque_share", "saturated_ticks")
    rows = [(f"`{m}`", *(shown(run, m) for run in runs)) for m in metrics]
    return table(("metric", "`active_set`", "`daqp`"), rows)


def scenarios() -> str:
    """Return the table of every shipped scenario."""
    parts = []
    for name in named_scenarios():
        label = {"tray_limits_first": "limits_first"}.get(name, name)
        run = run_of(label, name)
        result = "met" if run.summary["passed"] else "not met"
        parts.append(f"## `{name}`\n\n{run.summary['title']}: **{result}**.\n")
        parts.append(acceptance(label, name) + "\n")
    return "\n".join(parts).rstrip()


def pages() -> dict[str, Path]:
    """Return the page in which each block stands."""
    found = {}
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        for name in re.findall(r"<!-- measured:(\w+) -->", page.read_text(encoding="utf-8")):
            found[name] = page
    # tables of times come from kept results, by docs/benchmark_tables.py
    return {name: page for name, page in found.items() if name in BLOCKS}


BLOCKS: dict[str, Callable[[], str]] = {
    f.__name__: f for f in (tray, disturbances, priorities, solvers, daqp_run, scenarios)
}


def main(*names: str) -> None:
    """Measure and write the blocks of these names, or all."""
    for name, page in pages().items():
        if names and name not in names:
            continue
        inside = BLOCKS[name]()
        start, end = f"<!-- measured:{name} -->", f"<!-- /measured:{name} -->"
        before, rest = page.read_text(encoding="utf-8").split(start, 1)
        after = rest.split(end, 1)[1]
        page.write_text(f"{before}{start}\n\n{inside}\n\n{end}{after}", encoding="utf-8")
        print(f"{page.relative_to(ROOT)}: {name}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
