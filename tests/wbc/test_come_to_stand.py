"""A calm end: all that is wanted comes to a stand, and the law goes on."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.errors import InputError
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation

SLOWS_AT, WITHIN = 600, 0.6  # ticks, [s]


def stopped(robot: str | None = None, *overrides: str) -> tuple[Simulation, dict[str, np.ndarray]]:
    """Run a press in the middle of whose reach all is brought to a stand."""
    simulation = Simulation(read_scenario("press", ["duration=2.0", *overrides], robot=robot))
    run: dict[str, list[np.ndarray]] = {name: [] for name in ("q", "v", "tau", "mode", "v_ref")}
    for k, (t, record) in enumerate(simulation.ticks()):
        if k + 1 == SLOWS_AT:
            simulation.controller.come_to_stand(t + 1e-3, WITHIN)
        for name, kept in run.items():
            kept.append(record[name].copy())
    return simulation, {name: np.array(kept) for name, kept in run.items()}


@pytest.mark.parametrize(
    ("robot", "given"),
    [
        (None, ["physics.engine=rigid"]),
        (None, ["physics.engine=rigid", "control.governor={}"]),
        ("g1", ["physics.engine=mujoco"]),
    ],
)
def test_a_robot_that_moves_comes_to_rest_without_a_jerk(robot, given):
    simulation, run = stopped(robot, *given)
    rates = np.abs(run["v"][:, 6:]).max(axis=1)
    assert rates[SLOWS_AT - 1] > 0.1  # it was moving,
    still = SLOWS_AT + int(1000 * WITHIN) + 300
    assert rates[still:].max() < 0.05  # and has come to rest
    assert (run["mode"] == 0).all()
    assert simulation.controller.clock[0] == 0.0
    before = np.abs(np.diff(run["v_ref"][:SLOWS_AT], axis=0)).max()
    after = np.abs(np.diff(run["v_ref"][SLOWS_AT:], axis=0)).max()
    assert after < 2.0 * before  # no jerk that the motion itself has not
    jumps = np.abs(np.diff(run["tau"][SLOWS_AT - 10 :], axis=0)) / simulation.robot.tau_max
    assert jumps.max() < 0.05


def test_the_targets_stay_on_their_way():
    """The hand ends where it would have been half of the slowing later, whatever it does there."""
    simulation, run = stopped()
    other = Simulation(read_scenario("press", ["duration=2.0"]))
    free = [record["q_ref"].copy() for _, record in other.ticks()]
    where = round(SLOWS_AT + 500 * WITHIN)
    kin, end = simulation.robot.at(free[where]), simulation.robot.at(run["q"][-1])
    for palm in simulation.robot.palms:
        went = kin.placement(palm.frame).translation - end.placement(palm.frame).translation
        assert np.linalg.norm(went) < 5e-3


def test_no_time_is_refused():
    simulation = Simulation(read_scenario("press", ["duration=0.1"]))
    with pytest.raises(InputError):
        simulation.controller.come_to_stand(np.nan, 0.5)
    with pytest.raises(InputError):
        simulation.controller.come_to_stand(0.0, 0.0)
