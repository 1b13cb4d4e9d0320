"""A tick of a run is rebuilt as it was, explained, saved, and solved again without the run."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

from equipoise import load_run, run_scenario
from equipoise.analysis import explain_run
from equipoise.analysis.explain_run import rebuild_tick
from equipoise.analysis.feet_phases import phases_sentence
from equipoise.cli import cli
from equipoise.contacts import Phase
from equipoise.errors import InputError, NameNotFoundError, NonFiniteError
from equipoise.hqp import Hierarchy, certify, load_problem, make_solver
from equipoise.scenarios import parse_scenario
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.build.walk import build_walk
from equipoise.simulation.led_log import lead_again

SLOW_JOINTS = (
    "duration=0.7",
    "tasks.limits.velocity_share=0.02",
    "tasks.limits.priority=1",
    "world.objects.tray.waypoints.1.t=0.9",
    "tasks.look.window=[0.1, 6.0]",
    "tasks.look.ramp=0.2",
)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The tray with joints far too slow for it, and a gaze that fades in."""
    folder = tmp_path_factory.mktemp("explain") / "run"
    return run_scenario("tray", out=folder, overrides=SLOW_JOINTS, figures=False)


@pytest.mark.parametrize("t", [0.0, 0.05, 0.2, 0.5, 0.699])
def test_the_rebuilt_velocity_is_the_logged_one(run, t) -> None:
    tick = rebuild_tick(run.folder, t + 2e-4)
    assert tick.t == pytest.approx(t)
    assert tick.difference < (1e-9 if t > 0.3 else 2e-5)  # at rest the optimum is hardly defined
    assert list(tick.fading) == (["look"] if t == 0.2 else [])
    assert t < 0.3 or tick.solution.certificate(tick.hierarchy).holds(1e-6)


def test_what_is_named_blocks_and_giving_way_meets_the_task(run) -> None:
    tick = rebuild_tick(run.folder, 0.69)
    said = tick.explain()
    short = said.of("left_hand")
    assert said.optimal
    assert any("the speed limit of" in b.phrase for b in short.breaking)
    lower, upper = tick.hierarchy.lower.copy(), tick.hierarchy.upper.copy()
    for b in short.breaking:
        (upper if b.broken > 0.0 else lower)[b.row] += b.broken
    h = tick.hierarchy
    eased = make_solver("cascade").solve(Hierarchy(h.A, lower, upper, h.ends, h.blocks))
    hand = next(b for b in h.blocks if b.name == "left_hand")
    assert short.size > 1e-2
    assert np.linalg.norm(eased.w[hand.rows]) < 1e-5 * short.size
    assert eased.slack[0] < 1e-9


def test_the_sentence_says_by_how_much_in_units_of_the_task(run) -> None:
    """A hand short by w m/s at a rate of 10 /s is short by w / 10 m."""
    tick = rebuild_tick(run.folder, 0.69)
    short = tick.explain().of("left_hand")
    hand = next(b for b in tick.hierarchy.blocks if b.name == "left_hand")
    w = tick.solution.w[hand.rows]
    metres = next(value for value, unit in short.amounts if unit == "m")
    assert metres == pytest.approx(np.linalg.norm(w[:3]) / 10.0)
    assert str(short).startswith("left_hand is ")
    assert "blocked by the speed limit of " in str(short)


def test_the_command_explains_and_saves(run, tmp_path) -> None:
    file = tmp_path / "tick.npz"
    runner = CliRunner()
    done = runner.invoke(cli, ["explain", str(run.folder), "--at", "0.69", "--save", str(file)])
    assert done.exit_code == 0, done.output
    assert "left_hand is" in done.output
    again = runner.invoke(cli, ["explain", str(file), "--task", "left_hand", "--details"])
    assert again.exit_code == 0, again.output
    assert "t = 0.69 s" in again.output
    assert "would have to give" in again.output
    sentence = next(line for line in done.output.splitlines() if line.startswith("left_hand is"))
    assert sentence in again.output
    problem = load_problem(file)
    assert certify(problem.hierarchy, make_solver("cascade").solve(problem.hierarchy).v).holds()


def test_a_ramp_is_told(run) -> None:
    done = CliRunner().invoke(cli, ["explain", str(run.folder), "--at", "0.2"])
    assert "look by 50%" in done.output


@pytest.mark.parametrize(
    ("t", "span"), [(-1.0, "0 to 0.699"), (0.8, "0 to 0.699"), (1e9, "0.699 s")]
)
def test_a_time_outside_says_what_there_is(run, t, span) -> None:
    with pytest.raises(InputError, match=span):
        rebuild_tick(run.folder, t)


def test_a_time_that_is_none_is_refused(run) -> None:
    with pytest.raises(NonFiniteError, match="finite number"):
        rebuild_tick(run.folder, float("nan"))
    missing = CliRunner().invoke(cli, ["explain", str(run.folder)])
    assert isinstance(missing.exception, InputError)
    assert "--at T" in str(missing.exception)
    with pytest.raises(NameNotFoundError, match="left_hand"):
        rebuild_tick(run.folder, 0.2).explain(("lefthand",))


def test_a_run_that_breaks_off_says_so(run, tmp_path) -> None:
    cut = tmp_path / "run.mcap"
    whole = (run.folder / "run.mcap").read_bytes()
    cut.write_bytes(whole[: len(whole) // 2])
    last = load_run(cut).t[-1]
    assert rebuild_tick(cut, last).difference < 1e-9
    with pytest.raises(InputError, match=rf"breaks off.*from 0 to {last:g} s"):
        rebuild_tick(cut, 0.69)


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    """A walk until its first foot is in the air."""
    folder = tmp_path_factory.mktemp("walked") / "run"
    changes = ["duration=1.9", "physics.engine=rigid"]
    return run_scenario("walk", out=folder, overrides=changes, figures=False)


def test_a_tick_of_a_walk_is_rebuilt_with_what_its_feet_did(walked) -> None:
    tick = rebuild_tick(walked.folder, 1.8)
    assert tick.difference < 1e-6
    assert tick.feet == (f"left foot: {Phase.HELD.value}", f"right foot: {Phase.FREE.value}")
    assert {"walk left_sole", "walk com"} <= set(tick.tasks)
    assert phases_sentence(walked) == "Feet: as planned on every tick."


def test_a_walk_whose_log_does_not_say_where_it_was_led(walked, monkeypatch) -> None:
    monkeypatch.setattr(explain_run, "lead_again", lambda targets, values: False)
    with pytest.raises(InputError, match="of a version before"):
        rebuild_tick(walked.folder, 1.8)
    scenario = parse_scenario(walked.scenario_text)
    targets = build_walk(scenario, build_setup(scenario)).targets
    names = [name for name in walked if name.startswith("led/")]
    values = {name: walked[name][-1] for name in names}
    assert lead_again(targets, values)
    for name, led in targets.named.items():
        place = pin.SE3ToXYZQUAT(led.at(0.0).T_world_target)
        sign = np.sign(place[3:] @ values[f"led/{name}"][3:7])  # q and -q are one rotation
        assert np.allclose([*place[:3], *(sign * place[3:])], values[f"led/{name}"][:7])
    assert not lead_again(targets, {name: values[name] for name in names[1:]})
