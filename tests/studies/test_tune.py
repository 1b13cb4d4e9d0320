"""Gains are found on an ensemble, judged on a hold-out, and refused if they are not better."""

from __future__ import annotations

from math import log
from pathlib import Path
from typing import Any

import made_up
import pytest

from equipoise.errors import InputError
from equipoise.scenarios import read_scenario
from equipoise.scenarios.gains_file import gains_overrides, read_gains
from equipoise.studies.journal import Result
from equipoise.studies.plan import Plan
from equipoise.studies.tune import search
from equipoise.studies.tune.cost import Cost
from equipoise.studies.tune.read import named_tunings, read_tune
from equipoise.studies.tune.schema import TuneSpec

for _package in ("pyarrow", "optuna"):
    pytest.importorskip(_package)

BEST = 30.0  # the alpha at which the made-up runs below are best
SPEC: dict[str, Any] = {
    "name": "made_up",
    "scenario": "press",
    "gains": {"control.gains.alpha": {"log_uniform": [1.0, 100.0]}},
    "fixed": {"control.gains.k_ip": 3.0},
    "parameters": {"mass": {"path": "disturbances.mass_scale", "uniform": [0.5, 1.5]}},
    "ensemble": {"kind": "sobol", "points": 4, "seed": 1},
    "hold_out": {"kind": "sobol", "points": 8, "seed": 2},
    "good": {"path_error": {"max": 0.02}},
    "trials": 25,
}


def spec(**changes: Any) -> TuneSpec:
    return TuneSpec.model_validate({**SPEC, **changes})


class FakeBench(search._Bench):
    """Runs by a formula: an error that grows away from the best gain, and falls on the hold-out."""

    falls_on_hold_out = False
    advised = 10.0  # the alpha of the adviser
    runs = 0

    def run(self, where: str, gains: Any, trial: int) -> list[Result]:
        alpha = self.advised if gains is None else gains["control.gains.alpha"]
        found = []
        for run in list(Plan(self.study).first())[: getattr(self.spec, where).points]:
            FakeBench.runs += 1
            falls = self.falls_on_hold_out and where == "hold_out" and gains is not None
            error = 0.001 * (1.0 + log(alpha / BEST) ** 2)
            found.append(made_up.result(run, error, stands=not falls))
        return found


def tuned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, **changes: Any) -> Any:
    monkeypatch.setattr(search, "_Bench", FakeBench)
    said: list[str] = []
    outcome = search.tune(spec(**changes), tmp_path / "tuned", say=said.append)
    return outcome, said


def test_better_gains_are_found_and_scenarios_take_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outcome, said = tuned(tmp_path, monkeypatch)
    assert outcome.better
    assert outcome.file is not None
    alpha = outcome.gains["control.gains.alpha"]
    assert abs(log(alpha / BEST)) < 0.5 * abs(log(10.0 / BEST))
    assert read_gains(outcome.file) == {"control.gains.k_ip": 3.0, "control.gains.alpha": alpha}
    gains = read_scenario("press", gains_overrides(outcome.file)).control.gains
    assert (gains.alpha, gains.k_ip) == (alpha, 3.0)
    assert said[0].startswith("adviser: cost 0.00, 4 of 4 stand")


def test_gains_that_fall_on_the_hold_out_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Better on the ensemble by far; an earlier file of gains does not stay either."""
    outcome, _ = tuned(tmp_path, monkeypatch)
    assert outcome.file.exists()
    monkeypatch.setattr(FakeBench, "falls_on_hold_out", True)
    outcome, _ = tuned(tmp_path, monkeypatch)
    assert outcome.ensemble[1].cost < outcome.ensemble[0].cost
    assert not outcome.better
    assert outcome.sentences()[-1].startswith("Refused: after 25 trials")
    assert not (tmp_path / "tuned" / "gains.yaml").exists()


def test_an_adviser_that_is_best_already_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FakeBench, "advised", BEST)
    assert not tuned(tmp_path, monkeypatch)[0].better


def test_the_same_search_finds_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = (tuned(tmp_path / name, monkeypatch)[0].gains for name in ("a", "b"))
    assert first == second
    assert tuned(tmp_path / "c", monkeypatch, seed=1)[0].gains != first


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"hold_out": SPEC["ensemble"]}, "the hold-out must be other points"),
        ({"hold_out": None}, "hold_out"),
        ({"gains": {"faults.torque_share": {"uniform": [0.0, 1.0]}}}, "does not belong to control"),
        ({"gains": {"control.gains.alpha": {"uniform": [2.0, 1.0]}}}, "must be larger"),
    ],
)
def test_a_search_without_an_honest_judge_is_refused(changes: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        spec(**changes)


def test_a_folder_belongs_to_one_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tuned(tmp_path, monkeypatch)
    with pytest.raises(InputError, match="holds another search"):
        tuned(tmp_path, monkeypatch, cost={"path_error": 2.0})
    tuned(tmp_path, monkeypatch, trials=26)  # more of the same is no other search


def test_the_cost_is_zero_at_the_medians_and_a_fall_is_dear() -> None:
    runs = list(Plan(made_up.study()).first())
    errors = [0.001, 0.002, 0.004]
    results = [made_up.result(run, error) for run, error in zip(runs, errors, strict=False)]
    cost = Cost.over(results, {"path_error": 2.0}, fall=5.0, duration=2.0)
    assert [cost.of_run(one) for one in results] == pytest.approx([-2 * log(2), 0.0, 2 * log(2)])
    fallen = made_up.result(runs[0], 0.001, stands=False)
    assert cost.of_run(fallen) == pytest.approx(5.0 + 0.5)  # after 1 s of 2
    assert cost.of_run(made_up.result(runs[0], 1e9)) == 5.0  # never dearer than a fall


def test_shipped_files_can_be_read_for_every_robot() -> None:
    for name in named_tunings():
        for robot in ("hrp2", "talos", "g1", "romeo"):
            whole, small = (read_tune(name, robot=robot, small=small) for small in (False, True))
            assert small.trials < whole.trials
