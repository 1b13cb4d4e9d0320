"""Studies whose runs are made up by a formula, so that what should come out is known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from equipoise.studies.folder import StudyFolder
from equipoise.studies.journal import Result
from equipoise.studies.plan import Plan, StudyRun
from equipoise.studies.results import write_design, write_tables
from equipoise.studies.runner import described
from equipoise.studies.schema import StudySpec

Formula = Callable[[StudyRun], dict[str, Any]]


def study(**changes: Any) -> StudySpec:
    """Return a study of two controllers and two parameters; `changes` replace its keys."""
    whole: dict[str, Any] = {
        "name": "made_up",
        "scenario": "press",
        "controllers": {"first": {}, "second": {"title": "the second"}},
        "parameters": {
            "load": {"path": "x", "uniform": [0.0, 10.0], "nominal": 0.0, "unit": "kg"},
            "delay": {"path": "y", "uniform": [0.0, 8.0], "nominal": 0.0, "unit": "ms"},
        },
        "designs": {"main": {"kind": "sobol", "points": 16, "seed": 1}},
        "good": {"path_error": {"max": 0.02}},
        "metrics": ["path_error", "torque_effort"],
    }
    return StudySpec.model_validate({**whole, **changes})


def result(run: StudyRun, error: float, *, stands: bool = True) -> Result:
    """Return a result with a palm error [m]; good below 20 mm."""
    good = stands and error < 0.02
    row = {
        "stands": stands,
        "good": good,
        "cause": "" if good else "path_error" if stands else "fell",
        "why": "",
        "t_end": 1.0,
        "metrics": {"path_error": error, "torque_effort": 0.1 + error},
    }
    times = {"wall": 1.0, "tick_median_us": 25.0, "tick_p99_us": 40.0}
    return {"id": str(run.id), "row": described(run) | row, "times": times}


def play(spec: StudySpec, formula: Callable[[StudyRun], Result]) -> dict[str, Result]:
    """Return the results of all runs that a plan asks for, by id."""
    plan, results = Plan(spec), {}
    for start in plan.first():
        run: StudyRun | None = start
        while run is not None:
            found = formula(run)
            results[str(run.id)] = found
            run = plan.after(run.id, good=found["row"]["good"])
    return results


def write(spec: StudySpec, formula: Callable[[StudyRun], Result], place: Path) -> Path:
    """Write a whole study folder; return it."""
    folder = StudyFolder(place)
    folder.open(spec)
    write_design(folder, spec)
    write_tables(folder, spec, play(spec, formula))
    return place
