"""Waypoints out of reach are told before the run, with how far they are missed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from equipoise import read_scenario, run_scenario
from equipoise.robots import get_robot, named_robots
from equipoise.scenarios import named_scenarios
from equipoise.simulation.simulation import Simulation
from helpers import HUMANOIDS

ROBOTS = named_robots()
UP = "{t: 0.2, xyz: [%.3f, %.3f, %.3f]}"


def misses(scenario: str, robot: str, overrides: list[str]) -> list:
    spec = read_scenario(scenario, overrides)
    if robot not in ("hrp2", spec.robot):
        spec = read_scenario(scenario, overrides, robot=robot)
    if ROBOTS[spec.robot].missing:
        pytest.skip(f"{spec.robot} is not installed: {ROBOTS[spec.robot].missing}")
    return list(Simulation(spec).assembly.misses)


def hand_to(*points: np.ndarray) -> str:
    way = [f"{{t: {0.5 * (k + 1)}, xyz: {[round(float(x), 4) for x in p]}}}" for k, p in
           enumerate(points)]  # fmt: skip
    return (
        "tasks.right_hand={kind: frame_path, frame: right_palm, priority: 2, "
        f"waypoints: [{', '.join(way)}]}}"
    )


@pytest.mark.parametrize(
    "name", sorted(set(named_scenarios()) - {"tray_real", "tray_slip", "two_arms_slip"})
)
def test_what_is_shipped_is_within_reach(name: str) -> None:
    overrides = ["physics.engine=rigid"] if name == "telephone_real" else []
    assert misses(name, "hrp2", overrides) == []


@pytest.mark.parametrize("robot", HUMANOIDS)
def test_a_waypoint_is_missed_by_what_it_lies_beyond_the_reach(robot: str) -> None:
    """Pulled out in one direction, each further metre is missed whole; the ones before are met."""
    if ROBOTS[robot].missing:
        pytest.skip(f"{robot} is not installed: {ROBOTS[robot].missing}")
    made = get_robot(robot)
    start = made.at(made.q_half_sitting).placement("right_palm").translation
    near, far = start + np.array([0.05, 0.0, 0.05]), start + np.array([2.0, 0.0, 0.2])
    farther = far + np.array([1.0, 0.0, 0.1])
    found = misses("press", robot, [hand_to(start, near, far, near, farther)])
    numbers = {miss.number: miss for miss in found if miss.distance > 0.05}
    assert set(numbers) == {2, 4}
    reach = np.linalg.norm(far - start) - numbers[2].distance
    assert 0.05 < reach < 1.2
    grown = numbers[4].distance - numbers[2].distance
    assert grown == pytest.approx(np.linalg.norm([1.0, 0.1]), abs=0.05)


def test_what_is_off_or_never_comes_is_not_looked_at() -> None:
    far = np.array([3.0, 0.0, 1.0])
    near = np.array([0.2, -0.3, 0.9])
    assert misses("press", "hrp2", [hand_to(near, far)])
    assert not misses("press", "hrp2", [hand_to(near, far), "duration=0.9"])
    assert not misses("press", "hrp2", [hand_to(near, far), "tasks.right_hand.enabled=false"])


class Told:
    """Notes what is told, and that nothing was simulated until then."""

    def __init__(self) -> None:
        self.sentences: list[str] = []
        self.stages: list[str] = []

    def __call__(self, stage: str, share: float | None) -> None:
        self.stages.append(stage)

    def tell(self, sentence: str) -> None:
        assert "simulating" not in self.stages
        self.sentences.append(sentence)


def test_it_is_told_before_the_run_and_stays_in_the_summary(tmp_path: Path) -> None:
    told, far = Told(), np.array([3.0, 0.0, 1.0])
    overrides = [hand_to(np.array([0.2, -0.3, 0.9]), far), "duration=0.6"]
    far_soon = [overrides[0].replace("t: 1.0", "t: 0.55"), overrides[1]]
    run = run_scenario("press", out=tmp_path / "r", overrides=far_soon, figures=False, report=told)
    assert len(told.sentences) == 1
    assert (
        "right_hand cannot reach its waypoint 1 (t = 0.55 s): it misses it by" in told.sentences[0]
    )
    assert told.sentences[0] in run.summary["changes"]
