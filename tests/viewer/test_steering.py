"""Operator a running simulation: what is wished happens, is logged, and nothing else happens."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from steered_runs import Script, simulation

from equipoise.runlog import Run, load_run
from equipoise.simulation.loop import Ending, RunOutcome, run_simulation
from equipoise.simulation.operator import OperatorRequest
from equipoise.simulation.simulation import Simulation

PUSH = np.array([40.0, -25.0, 10.0])


def run(folder: Path, script: Script | None, ticks: int = 40) -> tuple[Run, RunOutcome, Simulation]:
    made = simulation(ticks * 1e-3)
    if script is not None:
        made.operate(script)
    outcome = run_simulation(made, folder)
    return load_run(folder), outcome, made


@pytest.fixture(scope="module")
def free(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return run(tmp_path_factory.mktemp("free") / "run", None)[0]


def test_without_requests_nothing_changes(free: Run, tmp_path: Path) -> None:
    steered, outcome, _ = run(tmp_path / "run", Script({}))
    for name in free:
        assert np.array_equal(steered[name], free[name]), name
    assert outcome.changes == ()
    assert 0.0 < outcome.first_wall < outcome.wall
    assert set(steered) - set(free) == {"push", "push_point", "gains"}


def test_a_push_is_a_force_on_the_robot_newton_says(free: Run, tmp_path: Path) -> None:
    at = 20
    wish = OperatorRequest(push=tuple(PUSH), push_frame="BODY")
    pushed, outcome, made = run(tmp_path / "run", Script({at: wish}))
    assert np.array_equal(pushed["q"][: at + 1], free["q"][: at + 1])
    assert (pushed["push"][:at] == 0.0).all()
    assert (pushed["push"][at:] == PUSH).all()
    assert outcome.changes == ("t = 0.020 s: push (40, -25, 10) N at BODY",)
    change = _momentum_rate(pushed, made, at) - _momentum_rate(free, made, at)
    floor = sum(
        pushed[f"lam/{s}_sole"][at, :3] - free[f"lam/{s}_sole"][at, :3] for s in ("left", "right")
    )
    assert np.allclose(change, PUSH + floor, atol=0.02 * np.linalg.norm(PUSH))
    assert np.linalg.norm(floor) > 1.0


def _momentum_rate(run: Run, made: Simulation, k: int) -> np.ndarray:
    """Return the change of linear momentum [N] over the tick k, in world axes."""
    model = made.robot.model
    data = model.createData()
    momenta = [
        pin.computeCentroidalMomentum(model, data, run["q"][i].copy(), run["v"][i].copy()).linear
        for i in (k, k + 1)
    ]
    return (momenta[1] - momenta[0]) / made.dt


def test_a_wanted_force_is_added_exactly(free: Run, tmp_path: Path) -> None:
    steered, outcome, _ = run(
        tmp_path / "run", Script({10: OperatorRequest(forces={"grasp/fz": 7.5})})
    )
    shift = steered["lam_ref/grasp"] - free["lam_ref/grasp"]
    assert (shift[:10] == 0.0).all()
    assert np.allclose(shift[10:], 7.5, rtol=0.0, atol=1e-12)
    assert outcome.changes == ("t = 0.010 s: wanted force, added to grasp/fz: 7.5",)


def test_gains_change_for_the_law_and_in_the_log(free: Run, tmp_path: Path) -> None:
    wish = OperatorRequest(damping_factor=0.5, gains={"alpha": 8.0, "eta": 11.0})
    steered, outcome, made = run(tmp_path / "run", Script({15: wish, 25: OperatorRequest()}))
    labels = steered.channels["gains"].labels
    shown = {label: steered["gains"][:, i] for i, label in enumerate(labels)}
    inside = slice(15, 25)
    assert (shown["alpha"][inside] == 8.0).all()
    assert (shown["eta"][inside] == 11.0).all()
    assert (shown["K_d_factor"][inside] == 0.5).all()
    for values in shown.values():
        assert (values[:15] == values[0]).all()
        assert (values[25:] == values[0]).all()
    assert np.array_equal(steered["tau"][:15], free["tau"][:15])
    assert not np.allclose(steered["tau"][15], free["tau"][15])
    assert len(outcome.changes) == 6
    assert made.controller.law.posture.alpha == made.controller.law.gains.alpha == shown["alpha"][0]


@pytest.mark.parametrize(
    "wish",
    [
        OperatorRequest(gains={"alpah": 3.0}),
        OperatorRequest(gains={"alpha": -3.0}),
        OperatorRequest(damping_factor=0.0),
        OperatorRequest(damping_factor=np.nan),
        OperatorRequest(forces={"grasp/fx": 3.0}),
        OperatorRequest(forces={"grasp/fz": np.inf}),
        OperatorRequest(push=(np.nan, 0.0, 0.0), push_frame="BODY"),
        OperatorRequest(push=(1.0, 0.0, 0.0), push_frame="BDOY"),
    ],
)
def test_what_makes_no_sense_is_refused_in_words(
    free: Run, tmp_path: Path, wish: OperatorRequest
) -> None:
    steered, outcome, _ = run(tmp_path / "run", Script({5: wish}), ticks=8)
    assert outcome.ending is Ending.COMPLETED
    assert len(outcome.changes) == 1
    assert "refused" in outcome.changes[0]
    assert np.array_equal(steered["q"], free["q"][:8])
    assert np.array_equal(steered["tau"], free["tau"][:8])


def test_stopping_keeps_what_was_computed(tmp_path: Path) -> None:
    steered, outcome, _ = run(tmp_path / "run", Script({}, stop=12))
    assert outcome.ending is Ending.INTERRUPTED
    assert steered.complete
    assert len(steered.t) == 12
