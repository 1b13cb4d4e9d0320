"""One call for a whole run: scenario in; folder with log, summary and figures out."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from equipoise.analysis.metrics.verdict import check_acceptance, judge, passed
from equipoise.analysis.run_context import RunContext
from equipoise.errors import InputError
from equipoise.runlog import Run, load_run, new_run_folder, write_summary
from equipoise.scenarios import Scenario, read_scenario
from equipoise.simulation.loop import Ending, RunOutcome, run_simulation
from equipoise.simulation.operator import Operator
from equipoise.simulation.simulation import Simulation

Report = Callable[[str, float], None]


def run_scenario(
    scenario: Scenario | str,
    *,
    out: Path | str | None = None,
    overrides: Sequence[str] = (),
    robot: str | None = None,
    figures: bool = True,
    report: Report | None = None,
    steer: Callable[[Simulation, Path], Operator] | None = None,
) -> Run:
    """Run a scenario (a name, a YAML path or an object) and return its loaded log.

    A named scenario is refitted to `robot` (a name or a path), if one is given.

    `out` is the run's folder; by default a new one under `runs/`. `report(stage, share)` is told
    how far it is, share in [0, 1]. `steer(simulation, folder)` returns who may change things
    while it runs (the live viewer). The folder then holds `run.mcap`, `scenario.yaml`,
    `summary.json` and, unless switched off, `figures/`.
    Raises: `InputError` (a wrong scenario), `RunLogError` (the folder cannot be written).
    """
    say = report or _say_nothing
    spec = (
        scenario
        if isinstance(scenario, Scenario)
        else read_scenario(scenario, overrides, robot=robot)
    )
    check_acceptance(spec)
    say("starting posture", 0.0)
    if out is not None and (Path(out) / "run.mcap").exists():
        raise InputError("the folder already holds a run", given=str(out), remedy="Give a new one")
    simulation = Simulation(spec)
    folder = Path(out) if out is not None else new_run_folder(Path("runs"), spec.name)
    if steer is not None:
        simulation.steer(steer(simulation, folder))
    outcome = run_simulation(simulation, folder, lambda t: say("simulating", t / spec.duration))
    say("measuring", 0.0)
    run = load_run(folder)
    write_summary(folder, summarise(run, simulation, outcome))
    if figures and outcome.ending is not Ending.INTERRUPTED:
        from equipoise.analysis.figures.make import make_figures

        say("drawing", 0.0)
        make_figures(run, folder / "figures")
    return load_run(folder)


def summarise(run: Run, simulation: Simulation, outcome: RunOutcome) -> dict[str, Any]:
    """Return what `summary.json` holds."""
    rows = judge(RunContext.of(run, simulation.setup))
    return {
        "scenario": run.info.get("scenario", ""),
        "title": simulation.scenario.title,
        "robot": simulation.robot.name,
        "seed": run.seed,
        "ended": outcome.ending.name.lower(),
        "note": outcome.note or outcome.ending.value,
        "passed": outcome.ending is Ending.COMPLETED and passed(rows),
        "simulated_s": outcome.t_end,
        "changes": list(outcome.changes),
        "metrics": rows,
        "gains": list(simulation.advice.sentences()),
        "timing": {**asdict(outcome), "ending": outcome.ending.name, "cpu": platform.machine()},
        "versions": dict(run.info),
    }


def _say_nothing(stage: str, share: float) -> None:
    pass
