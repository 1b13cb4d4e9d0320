"""Runs of a study one after the other in one process: what they share is kept between them."""

from __future__ import annotations

import copy
import shutil
from collections.abc import Iterable
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from pydantic import ValidationError

from equipoise.analysis.metrics import METRICS
from equipoise.analysis.metrics.registry import RENAMED
from equipoise.errors import EquipoiseError, NameNotFoundError, ScenarioError
from equipoise.scenarios import Scenario, read_scenario
from equipoise.scenarios.complaints import complaint
from equipoise.scenarios.lookup import at_path
from equipoise.scenarios.overrides import write_value
from equipoise.scenarios.schema import Limit
from equipoise.simulation.build.assemble import Prepared
from equipoise.simulation.simulation import Simulation
from equipoise.studies.in_memory import COMPLETED, DIVERGED, Ticks, run_in_memory
from equipoise.studies.journal import Result
from equipoise.studies.plan import Plan, StudyRun, overrides_of
from equipoise.studies.schema import StudySpec

# what a starting posture does not depend on
NOT_OF_THE_START = {"name", "title", "duration", "seed", "control", "physics", "disturbances",
                    "sensors", "faults", "acceptance", "monitor"}  # fmt: skip
TRIED = 0.8  # [s] in which a robot without torques falls
LOST, NOT_RUN = "killed its worker", "could not be run"
# how causes of the supervisor begin to be alike: words in its sentence, the name of the cause
CAUSES = {
    "tilted": "fell",
    "from its reference": "left its reference",
    "moves at": "a joint too fast",
    "no measurement": "a sensor lost",
}


class Runner:
    """Runs single runs of a study. Raises: `ScenarioError` if its scenario is wrong."""

    def __init__(self, study: StudySpec) -> None:
        self.study = study
        base = read_scenario(study.scenario, robot=study.robot)
        self._tree: dict[str, Any] = base.model_dump(mode="json", exclude_none=True)
        self._prepared: dict[str, Prepared] = {}
        self.bounds = {name: _renamed(getattr(study, name)) for name in ("stands", "good")}
        wanted = [*self.bounds["stands"], *self.bounds["good"], *study.metrics]
        self.metrics = list(dict.fromkeys(RENAMED.get(name, name) for name in wanted))

    def check(self) -> None:
        """Refuse a study of which a run could not be begun. Raises: `ScenarioError`."""
        self.check_scenario()
        seen = set()
        for run in Plan(self.study).first():
            if run.controller not in seen:
                seen.add(run.controller)
                try:
                    self.simulation(run)
                except ScenarioError as error:
                    raise error.at(f"controllers.{run.controller}") from None

    def check_scenario(self) -> None:
        """Refuse metrics that do not exist. Raises: `ScenarioError`."""
        for name in self.metrics:
            if name not in METRICS:
                raise at_path(NameNotFoundError("metric", name, METRICS), "metrics")

    @property
    def duration(self) -> float:
        """How long [s] a run lasts if nothing ends it."""
        return self._scenario(self.study.set.items()).duration

    def scenario(self, run: StudyRun) -> Scenario:
        """Return the scenario of a run. Raises: `ScenarioError`."""
        return self._scenario(overrides_of(self.study, run))

    def _scenario(self, overrides: Iterable[tuple[str, Any]]) -> Scenario:
        tree = copy.deepcopy(self._tree)
        for path, value in overrides:
            write_value(tree, path, value)
        try:
            return Scenario.model_validate(tree)
        except ValidationError as error:
            raise complaint(error, tree, tree, Scenario) from None

    def simulation(self, run: StudyRun) -> Simulation:
        """Return a run ready to run; what it shares with earlier ones is taken from them."""
        scenario = self.scenario(run)
        control = scenario.control
        key = scenario.model_dump_json(exclude=NOT_OF_THE_START)
        key += f"{scenario.duration} {control.period} {control.contact_rate} {control.solver}"
        simulation = Simulation(scenario, self._prepared.get(key))
        found = simulation.assembly
        self._prepared.setdefault(key, Prepared(simulation.robot, found.q_start, found.outlook))
        return simulation

    def try_out(self, run: StudyRun) -> None:
        """Run a run for a moment without any torque, so that all its kernels are at hand."""
        weak = (*overrides_of(self.study, run), ("faults.torque_share", 0.0), ("duration", TRIED))
        try:
            simulation = Simulation(self._scenario(weak))
            run_in_memory(simulation, stop_when_off=False).metrics(self.metrics)
        except Exception:  # the run itself will say it
            return

    def run(self, run: StudyRun, logs: Path | None = None) -> Result:
        """Run one and return its result; a run that is not good leaves a log under `logs`.

        What a run raises is its result, too. Raises: `OSError` if the disk refuses.
        """
        wall, cpu = perf_counter(), process_time()
        try:
            ticks = run_in_memory(self.simulation(run), stop_when_off=self.study.stop_when_off)
            row = self._judged(run, ticks)
        except OSError:
            raise
        except Exception as error:  # whatever a controller does, the study goes on
            return failed(run, NOT_RUN, f"{type(error).__name__}: {error}")
        if logs is not None and not row["good"]:
            self._keep(run, ticks, logs)
        times = _times(ticks) | {"wall": perf_counter() - wall, "cpu": process_time() - cpu}
        return {"id": str(run.id), "row": row, "times": times}

    def _judged(self, run: StudyRun, ticks: Ticks) -> dict[str, Any]:
        values = ticks.metrics(self.metrics)
        broken = {
            kind: [name for name, limit in bounds.items() if not _within(values.get(name), limit)]
            for kind, bounds in self.bounds.items()
        }
        stands = not broken["stands"]
        return {
            **described(run),
            "stands": stands,
            "good": stands and not broken["good"],
            "cause": _cause(ticks, broken),
            "why": ticks.why,
            "t_end": float(ticks.t[-1]) + ticks.simulation.dt if len(ticks.t) else 0.0,
            "metrics": values,
        }

    def _keep(self, run: StudyRun, ticks: Ticks, logs: Path) -> None:
        folder = logs / run.controller
        if folder.is_dir() and len(list(folder.iterdir())) >= self.study.logs:
            return
        place = folder / str(run.id).replace("/", "-")
        shutil.rmtree(place, ignore_errors=True)  # left by a worker that was killed
        try:
            ticks.write_log(place)
        except EquipoiseError as error:
            raise OSError(f"no log in {place}: {error}") from error


def described(run: StudyRun) -> dict[str, Any]:
    """Return what is known of a run before it runs."""
    return {"controller": run.controller, "line": run.line, "share": run.share,
            "values": run.values}  # fmt: skip


def failed(run: StudyRun, cause: str, why: str) -> Result:
    """Return the result of a run that gave no numbers."""
    row = {"stands": False, "good": False, "cause": cause, "why": why, "t_end": 0.0, "metrics": {}}
    return {"id": str(run.id), "row": described(run) | row, "times": {}}


def _cause(ticks: Ticks, broken: dict[str, list[str]]) -> str:
    """Return in a few words why a run is not good, "" if it is."""
    if ticks.ended == DIVERGED:
        return "diverged"
    if ticks.ended != COMPLETED or "mode_worst" in broken["stands"]:
        return next((name for words, name in CAUSES.items() if words in ticks.why), "law off")
    return ", ".join([*broken["stands"], *broken["good"]])


def _within(value: float | None, limit: Limit) -> bool:
    if value is None or np.isnan(value):
        return False
    return (limit.min is None or value >= limit.min) and (limit.max is None or value <= limit.max)


def _renamed(limits: dict[str, Limit]) -> dict[str, Limit]:
    return {RENAMED.get(name, name): limit for name, limit in limits.items()}


def _times(ticks: Ticks) -> dict[str, float]:
    """Return median and 99th percentile of a control tick, the first ones left out [us]."""
    spent = ticks.simulation.tick_ns[10 : len(ticks.t), 0] / 1000.0
    if not len(spent):
        return {}
    return {
        "tick_median_us": float(np.median(spent)),
        "tick_p99_us": float(np.percentile(spent, 99)),
        "loop_cpu": ticks.cpu,
    }
