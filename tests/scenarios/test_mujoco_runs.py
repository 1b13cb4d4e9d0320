"""Closed loop in MuJoCo: the same scenarios stand on a frictional floor, and say when they fail."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.errors import ScenarioError
from equipoise.physics import DivergedError
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation

pytest.importorskip("mujoco")

IN_MUJOCO = "physics.engine=mujoco"


def simulate(name: str, *overrides: str):
    """Return the simulation and the values of every tick by channel, up to a divergence."""
    simulation = Simulation(read_scenario(name, [IN_MUJOCO, *overrides]))
    rows = []
    try:
        for _, record in simulation.ticks():
            rows.append({key: value.copy() for key, value in record.views.items()})
    except DivergedError:
        pass
    return simulation, {key: np.array([row[key] for row in rows]) for key in rows[0]}


def stands(log) -> bool:
    """Return whether the base stayed within 5 cm of its reference."""
    return bool(np.abs(log["dq"][:, :3]).max() < 0.05)


@pytest.fixture(scope="module")
def pressing():
    """The press from nothing on a smooth wall, long enough to have settled."""
    smooth = "physics.mujoco.hand_friction=0.001"
    return simulate("press", "control.start=released", "duration=1.1", smooth)


def test_from_nothing_the_weight_is_caught_within_half_a_second(pressing):
    """No gravity compensation is given: the robot sags, is caught, and no sole leaves the floor."""
    simulation, log = pressing
    assert np.abs(log["tau"][0]).max() < 0.1 * simulation.robot.tau_max.max()
    lowest = int(np.argmin(log["dq"][:, 2]))
    assert log["dq"][lowest, 2] < -1e-3
    assert lowest < 500
    assert np.abs(log["dq"][500:, :3]).max() < 0.25 * np.abs(log["dq"][lowest, 2])
    for sole in ("left_sole", "right_sole"):
        assert log[f"lam/{sole}"][10:, 2].min() > 0.0
    assert abs(log["lam/press"][-1, 0] - log["lam_ref/press"][-1, 0]) < 1.0
    assert not log["mode"].any()


def test_with_three_milliseconds_of_delay_it_stands_only_because_the_reaction_is_filtered():
    overrides = ("control.start=released", "duration=0.4", "faults.measurement_delay=0.003")
    _, filtered = simulate("press", *overrides)
    _, at_face_value = simulate("press", *overrides, "control.reaction_filter=0.0")
    assert stands(filtered)
    assert not stands(at_face_value)


def test_what_the_sensors_read_moves_the_centre_of_mass(pressing):
    """Newton: the mean of all external forces is weight and change of momentum."""
    simulation, log = pressing
    first, last, step = 600, 1090, 5
    time = 1e-3 * (last - first)
    speed = [(log["com"][k + step] - log["com"][k - step]) / (2e-3 * step) for k in (first, last)]
    total = log["lam/left_sole"][first:last, :3] + log["lam/right_sole"][first:last, :3]
    total[:, 1] += log["lam/press"][first:last, 0]  # the wall's normal is y
    mass = simulation.robot.mass
    wanted = mass * ((speed[1] - speed[0]) / time + np.array([0.0, 0.0, 9.81]))
    assert np.abs(total.mean(axis=0) - wanted).max() < 0.5


def test_a_bounded_distribution_keeps_the_pressure_inside():
    _, log = simulate(
        "press", "control.start=released", "duration=0.5", "control.distribution=bounded"
    )
    assert stands(log)
    for sole in ("left_sole", "right_sole"):
        assert log[f"margin/{sole}"][100:].min() > 0.0


def test_the_welded_tray_goes_with_the_hands_and_is_logged():
    simulation, log = simulate("tray_real", "duration=0.6")
    target = simulation.setup.targets["tray"].at(0.6).T_world_target.translation
    assert np.linalg.norm(log["object/tray"][-1, :3] - target) < 0.005
    assert log["object/tray"][:, 7].max() < 0.02


def test_a_lost_force_sensor_is_told_with_its_name():
    silence = "faults.silences=[{sensor: press, start: 0.3}]"
    simulation, log = simulate("press", "control.start=released", "duration=0.5", silence)
    assert stands(log)
    assert log["mode"][-1, 0] == 1.0
    assert "the force of press" in simulation.story[0]


def test_a_lost_joint_ends_in_damping_and_never_over_a_limit():
    silence = "faults.silences=[{sensor: RARM_JOINT3, start: 0.2}]"
    simulation, log = simulate("press", "duration=0.4", silence)
    assert log["mode"][-1, 0] >= 2.0
    assert "RARM_JOINT3" in simulation.story[0]
    assert (np.abs(log["tau"]) <= simulation.robot.tau_max + 1e-12).all()


def test_a_misspelt_fault_is_explained():
    with pytest.raises(ScenarioError, match="Did you mean 'press'"):
        simulate("press", "faults.silences=[{sensor: pres, start: 0.3}]")
