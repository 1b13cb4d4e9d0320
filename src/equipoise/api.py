"""One call for a whole run: scenario in; folder with log, summary and figures out."""

from __future__ import annotations

import platform
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from equipoise.analysis.metrics.verdict import (
    check_acceptance,
    impossible,
    judge,
    passed,
    where_to_look,
)
from equipoise.analysis.run_context import RunContext
from equipoise.compiled import COST, watch_compilation
from equipoise.errors import AdviceWarning, ScenarioError
from equipoise.optional import is_installed
from equipoise.runlog import Run, load_run, new_run_folder, read_summary, write_summary
from equipoise.runlog.folders import check_place
from equipoise.scenarios import Scenario, read_scenario
from equipoise.scenarios.catalogue import place_error
from equipoise.simulation.controlled_run import ControlledRun
from equipoise.simulation.loop import Ending, RunOutcome, run_simulation
from equipoise.simulation.operator import Operator
from equipoise.simulation.simulation import Simulation

RUNS = Path("runs")
Report = Callable[[str, float | None], None]
NO_FIGURES = (
    "no figures were drawn: matplotlib is not installed (pip install 'equipoise[plot]'; "
    "equipoise plot RUN draws them later)"
)
COMPILING = f"compiling, once, {COST}"


def run_scenario(
    scenario: Scenario | str,
    *,
    out: Path | str | None = None,
    overrides: Sequence[str] = (),
    robot: str | None = None,
    figures: bool = True,
    report: Report | None = None,
    measured: Callable[[Run], None] | None = None,
    steer: Callable[[ControlledRun, Path], Operator] | None = None,
) -> Run:
    """Run a scenario (a name, a YAML path or an object) and return its loaded log.

    A named scenario is refitted to `robot` (a name or a path), if one is given.

    `out` is the run's folder; by default a new one under `runs/`. `report(stage, share)` is told
    how far it is, share in [0, 1], or None where that is not known; `report.tell(sentence)`, where
    there is one, which waypoints are out of reach, before anything moves. `measured(run)` is given
    the run with its summary before the figures are drawn. `steer(simulation, folder)` returns who
    may change things while it runs (the live viewer). The folder then holds `run.mcap`,
    `scenario.yaml`, `summary.json` and, unless switched off, `figures/`, pictures for Foxglove in
    the log, and `foxglove_layout.json`.
    Raises: `InputError` (a wrong scenario), `RunLogError` (the folder cannot be written).
    """
    output = Output(out, figures, report, measured, steer)
    with watch_compilation(output.say_compiling):
        spec = (
            scenario
            if isinstance(scenario, Scenario)
            else read_scenario(scenario, overrides, robot=robot)
        )
        try:
            return run_made(spec, Simulation, output)
        except ScenarioError as error:
            if isinstance(scenario, Scenario):
                raise
            raise place_error(error, scenario, overrides) from None


@dataclass(frozen=True)
class Output:
    """Where a run goes and who is told of it, as `run_scenario` has it."""

    out: Path | str | None = None
    figures: bool = True
    report: Report | None = None
    measured: Callable[[Run], None] | None = None
    steer: Callable[[ControlledRun, Path], Operator] | None = None

    @property
    def say(self) -> Report:
        """Whom to tell how far it is."""
        return self.report or _say_nothing

    def say_compiling(self, busy: bool) -> None:
        """Tell that kernels are being compiled."""
        if busy:
            self.say(COMPILING, None)


def run_made(
    spec: Scenario, make: Callable[[Scenario], ControlledRun], output: Output | None = None
) -> Run:
    """Run what `make` makes of a scenario, and return its loaded log: see `run_scenario`.

    Raises: `ScenarioError`, `RunLogError`, and what `make` raises.
    """
    output = output or Output()
    out, say = output.out, output.say
    check_place(Path(out) if out is not None else RUNS)
    say("starting posture", 0.0)
    check_acceptance(spec)
    made = make(spec)
    misses = [str(miss) for miss in made.controls.misses]
    for sentence in misses:
        getattr(output.report, "tell", _tell_nobody)(sentence)
    folder = Path(out) if out is not None else new_run_folder(RUNS, spec.name)
    if output.steer is not None:
        made.operate(output.steer(made, folder))
    outcome = run_simulation(made, folder, lambda t: say("simulating", t / spec.duration))
    outcome = replace(outcome, changes=(*misses, *outcome.changes))
    context = _measure(made, outcome, folder, say)
    if output.measured is not None:
        output.measured(context.run)
    if output.figures and outcome.ending is not Ending.INTERRUPTED:
        _draw(context, say)
    return context.run


def _measure(made: ControlledRun, outcome: RunOutcome, folder: Path, say: Report) -> RunContext:
    """Write the summary; return the run with it."""
    say("measuring", 0.0)
    context = RunContext(load_run(folder), made.scenario, made.setup)
    write_summary(folder, summarise(context, made, outcome))
    return replace(context, run=replace(context.run, summary=read_summary(folder)))


def _draw(context: RunContext, say: Report) -> None:
    from equipoise.analysis.figures.make import draw_figures
    from equipoise.analysis.foxglove.write import add_pictures

    say("drawing", 0.0)
    if context.drawable:
        add_pictures(context)
    if not is_installed("matplotlib"):
        warnings.warn(NO_FIGURES, AdviceWarning, stacklevel=4)
        return
    draw_figures(context, context.run.folder / "figures", lambda share: say("drawing", share))


def summarise(context: RunContext, made: ControlledRun, outcome: RunOutcome) -> dict[str, Any]:
    """Return what `summary.json` holds."""
    run, rows = context.run, judge(context)
    if outcome.ending is Ending.INTERRUPTED and "completed" in rows:
        rows["completed"].pop("fault", None)  # nothing impossible: somebody ended it
    faults = impossible(rows)
    return {
        "scenario": run.info.get("scenario", ""),
        "title": made.scenario.title,
        "robot": made.robot.name,
        "seed": run.seed,
        "ended": outcome.ending.name.lower(),
        "note": outcome.note or outcome.ending.value,
        "passed": outcome.ending is Ending.COMPLETED and passed(rows),
        "simulated_s": outcome.t_end,
        "changes": list(outcome.changes),
        "impossible": faults,
        "look": where_to_look(rows, run.folder),
        "metrics": rows,
        "gains": list(made.controls.advice.sentences()),
        "timing": {**asdict(outcome), "ending": outcome.ending.name, "cpu": platform.machine()},
        "versions": dict(run.info),
    }


def _tell_nobody(sentence: str) -> None:
    pass


def _say_nothing(stage: str, share: float | None) -> None:
    pass
