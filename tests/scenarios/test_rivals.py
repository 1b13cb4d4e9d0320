"""Rivals in scenarios: named by `control.kind`, with a model and gains of their own."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

from equipoise.cli import cli
from equipoise.control.modes import Mode
from equipoise.control.rivals.kinds import RIVALS
from equipoise.errors import ScenarioError
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.rivals import known_robot, tuned_rival
from equipoise.simulation.simulation import Simulation


def short(engine, *changes, kind="idqp"):
    return read_scenario(
        "press", [f"physics.engine={engine}", "duration=0.2", f"control.kind={kind}", *changes]
    )


def palms_apart(robot, record):
    """Return how far the palms are from their reference [m]."""
    at, ref = robot.at(record["q"].copy()), robot.at(record["q_ref"].copy())
    return max(
        np.linalg.norm(at.placement(p.frame).translation - ref.placement(p.frame).translation)
        for p in robot.palms
    )


@pytest.mark.parametrize("kind", RIVALS)
def test_every_rival_follows_the_press_on_a_floor_that_gives(kind):
    simulation = Simulation(short("mujoco", kind=kind))
    for _, record in simulation.ticks():
        assert palms_apart(simulation.robot, record) < 1e-3
    assert simulation.controller.supervisor.mode is Mode.RUN
    assert palms_apart(simulation.robot, record) < 5e-4
    # beside 20 N wanted at 0.8 s: the reference reached the rival, and the wall feels it
    wanted = float(simulation.controller.wanted[0])
    assert wanted > 3.0
    assert record["lam/press"][0] == pytest.approx(wanted, abs=2.5)


def test_a_rival_is_told_the_wanted_force():
    """It gets what the profile says, as the shipped law does."""
    simulation = Simulation(short("rigid", "duration=0.01"))
    told, step = [], simulation.controller.controller.step

    def noted(t, measured, reference):
        told.append(reference.lam_ref.copy())
        return step(t, measured, reference)

    simulation.controller.controller.step = noted
    for _ in simulation.ticks():
        np.testing.assert_array_equal(told[-1], simulation.controller.wanted)
    assert (np.array(told) >= 2.0).all()


def test_the_model_of_a_rival_is_wrong_as_told_and_the_plant_is_not(hrp2):
    """Its mass is scaled, its centre of mass moved as a whole, and its rotors are the engine's."""
    q = hrp2.q_half_sitting
    shift = [0.0, 0.0, 0.02]
    scenario = short(
        "mujoco", f"control.model={{mass_scale: 1.2, com_shift: {shift}}}",
        "physics.mujoco.armature=0.07",
    )  # fmt: skip
    known = known_robot(scenario, hrp2)
    assert known.mass == pytest.approx(1.2 * hrp2.mass)
    assert hrp2.mass == pytest.approx(56.037, abs=1e-3)
    moved = np.zeros(3)
    data = hrp2.model.createData()
    pin.forwardKinematics(hrp2.model, data, q)
    for joint, inertia in enumerate(hrp2.model.inertias):
        moved += inertia.mass / hrp2.mass * data.oMi[joint].rotation @ np.array(shift)
    np.testing.assert_allclose(known.at(q).p_world_com, hrp2.at(q).p_world_com + moved, atol=1e-12)
    plain = known_robot(short("mujoco", "physics.mujoco.armature=0.07"), hrp2)
    extra = pin.crba(plain.model, plain.model.createData(), q) - pin.crba(hrp2.model, data, q)
    np.testing.assert_allclose(np.diag(extra), np.r_[np.zeros(6), np.full(30, 0.07)], atol=1e-12)
    assert np.all(known_robot(short("rigid"), hrp2).model.armature == hrp2.model.armature)


def test_gains_of_a_scenario_go_over_those_of_the_engine():
    kind = RIVALS["idqp"]
    soft = tuned_rival(short("mujoco", "control.rival.kappa=77"), kind).gains
    rigid = tuned_rival(short("rigid"), kind).gains
    assert (soft.kappa, soft.alpha) == (77.0, kind.soft.alpha)
    assert rigid == kind.rigid
    with pytest.raises(ScenarioError, match=r"control\.rival.*kappa|kappa.*1/s") as error:
        tuned_rival(short("rigid", "control.rival.kappa=5000"), kind)
    assert error.value.path == "control.rival"


def test_the_controller_is_an_option_of_run():
    told = CliRunner().invoke(cli, ["run", "press", "--controller", "idpq", "--no-figures"])
    assert isinstance(told.exception, ScenarioError)
    assert told.exception.path == "control.kind"
    assert "idqp" in str(told.exception)
