"""Windows and ramps in a scenario: read, refused, and obeyed without a jump."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.errors import ScenarioError
from equipoise.scenarios import parse_scenario, read_scenario, resolved_text
from equipoise.simulation.build.fades import build_fades
from equipoise.simulation.simulation import Simulation

REACH = """
name: reach
duration: 1.0
contacts:
  left_sole: {kind: sole, sole: left_sole}
  right_sole: {kind: sole, sole: right_sole}
tasks:
  limits: {kind: joint_limits, priority: 1}
  hand:
    kind: frame_path
    frame: right_palm
    rate: 3.0
    calm: false
    priority: 2
    window: [0.1, 0.9]
    ramp: 0.2
    waypoints: [{t: 0.0, xyz: [0.3, -0.35, 0.85], rpy: [-1.57, 0.1, 0.0]}]
  posture: {kind: posture, rate: 2.0, priority: 3}
control: {period: 0.004}
"""


def velocities(scenario, until: float) -> tuple[np.ndarray, np.ndarray, list]:
    """Return times, v_ref and the steps of the motion alone."""
    simulation = Simulation(scenario)
    times = np.arange(round(until / simulation.dt)) * simulation.dt
    steps = []
    for t in times:
        steps.append(simulation.controller.motion.step(t))
        assert steps[-1].hierarchy is not None  # put together before the next one
    return times, np.array([s.v_ref for s in steps]), steps


def largest_step(times, v, around: float, width: float) -> float:
    change = np.abs(np.diff(v, axis=0)).max(axis=1)
    return change[np.abs(times[1:] - around) < width].max()


def test_a_window_is_read_written_and_built() -> None:
    scenario = parse_scenario(REACH)
    assert parse_scenario(resolved_text(scenario)) == scenario
    fade = build_fades(scenario)["hand"]
    assert (fade.start, fade.end, fade.ramp) == (0.1, 0.9, 0.2)
    assert build_fades(parse_scenario(REACH, ["tasks.hand.enabled=false"])) == {}
    assert (
        build_fades(parse_scenario(REACH, ["tasks.hand.window=[0.0, 0.9]"]))["hand"].weight(0.0)
        == 1.0
    )
    assert build_fades(read_scenario("telephone")) == {}


@pytest.mark.parametrize(
    ("override", "path"),
    [
        ("tasks.hand.ramp=0.5", "tasks.hand"),
        ("tasks.hand.ramp=-0.1", "tasks.hand.ramp"),
        ("tasks.hand.window=[0.9, 0.1]", "tasks.hand"),
        ("tasks.hand.window=[0.1]", "tasks.hand.window"),
        ("tasks.hand.window=[0.1, .nan]", "tasks.hand.window"),
    ],
)
def test_a_window_that_makes_no_sense_is_refused_by_its_path(override, path) -> None:
    with pytest.raises(ScenarioError, match=path):
        parse_scenario(REACH, [override])


def test_a_contact_cannot_be_led_into_before_time_0() -> None:
    with pytest.raises(ScenarioError, match="before time 0"):
        read_scenario("telephone", ["contacts.push.ramp=1.5"])


def test_a_task_in_a_window_starts_and_ends_without_a_jump() -> None:
    """A jump stays as it is when the period shrinks; a smooth change shrinks with it."""

    def steps_at(edge: float, width: float, *overrides: str) -> tuple[float, float]:
        sizes = []
        for period in (0.004, 0.001):
            scenario = parse_scenario(REACH, [f"control.period={period}", *overrides])
            times, v, _ = velocities(scenario, edge + width)
            sizes.append(largest_step(times, v, edge, width))
        return sizes[0], sizes[1]

    for edge in (0.1, 0.4):
        coarse, fine = steps_at(edge, 0.1, "tasks.hand.window=[0.1, 0.4]", "tasks.hand.ramp=0.15")
        assert fine < 0.4 * coarse
        coarse, fine = steps_at(edge, 0.01, "tasks.hand.window=[0.1, 0.4]", "tasks.hand.ramp=0")
        assert fine > 0.8 * coarse > 0.08


def test_a_task_has_rows_once_it_counts_fully() -> None:
    times, v, steps = velocities(parse_scenario(REACH), 0.4)
    assert np.abs(v[times < 0.1]).max() < 1e-3  # it does not start where the hand has to go
    there = ["hand" in [b.name for b in s.hierarchy.blocks] for s in steps]
    assert there == [t >= 0.3 for t in times.tolist()]


def test_a_contact_that_comes_early_needs_its_ramp() -> None:
    """The telephone is touched while the hand still moves: its row stops the hand, or leads it."""
    early = ["contacts.push.start=0.9", "control.period=0.004"]
    times, hard, _ = velocities(read_scenario("telephone", early), 1.0)
    _, soft, steps = velocities(read_scenario("telephone", [*early, "contacts.push.ramp=0.2"]), 1.0)
    assert largest_step(times, hard, 0.9, 0.01) > 0.05
    assert largest_step(times, soft, 0.85, 0.15) < 0.25 * largest_step(times, hard, 0.9, 0.01)
    for t, step in zip(times, steps, strict=True):
        if t >= 0.9:  # it holds: the velocity keeps to it fully
            assert step.solution.slack[0] < 1e-9
