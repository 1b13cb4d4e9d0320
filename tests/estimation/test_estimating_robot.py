"""Contact forces by the observer, and a robot that is driven on estimates alone."""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.estimation import EstimatingRobot, WrenchObserver
from equipoise.estimation.wrench_observer import WrenchRows
from equipoise.remote.drive import RemoteRun
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.assemble import (
    Prepared,
    assemble_controls,
    assemble_plant,
    starting_posture,
)
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.wire.interface import CommandMode, RobotCommand


@cache
def prepared() -> Prepared:
    scenario = read_scenario("press", ["duration=0.3"])
    setup = build_setup(scenario)
    return Prepared(setup.robot, starting_posture(scenario, setup))


class Blind:
    """A simulated robot without a sensor of its base and of its contacts, as those of Unitree."""

    def __init__(self, robot: SimulatedRobot) -> None:
        self.robot, self.write, self.close = robot, robot.write, robot.close

    def read(self, timeout: float):
        self.true = state = self.robot.read(timeout)
        q, v = state.q.copy(), state.v.copy()
        q[:7], v[:6] = np.nan, np.nan
        return state._replace(q=q, v=v, lam=np.full_like(state.lam, np.nan))


def driven(*changes: str, blind: bool = True, armature: bool = False):
    """Drive the press; yield estimate, truth and controller of every tick."""
    scenario = read_scenario("press", ["duration=0.3", *changes])
    controls = assemble_controls(scenario, prepared())
    setup, controller = controls.setup, controls.controller
    plant, tau = assemble_plant(scenario, setup, controls.q_start)
    robot = SimulatedRobot(plant, scenario.control.period, tau)
    behind = Blind(robot)
    seen = EstimatingRobot(
        behind,
        setup.robot,
        setup.contacts,
        setup.schedule,
        rotor_inertia=scenario.physics.mujoco.armature if armature else 0.0,
    )
    controller.take_over(tau)
    for k in range(round(scenario.duration / scenario.control.period)):
        t = k * scenario.control.period
        state = seen.read(0.0)
        used = state if blind else behind.true
        command = controller.step(t, used.q, used.v, used.lam)
        yield state, behind.true, controller
        robot.write(RobotCommand(t, CommandMode.TORQUE, np.array(command.tau)))


def test_a_standing_robot_is_carried_by_what_the_observer_says():
    """At rest the generalised force is gravity less torque: no model of contacts is needed."""
    scenario = read_scenario("press", ["duration=0.3"])
    setup = build_setup(scenario, prepared().robot)
    plant, tau = assemble_plant(scenario, setup, prepared().q_start)
    state = plant.engine.state
    observer = WrenchObserver(setup.robot, 0.004)
    force = observer.step(0.0, state.q, state.v, tau)
    kin = setup.robot.at(state.q)
    np.testing.assert_allclose(setup.contacts.jacobian(kin).T @ state.lam, force, atol=1e-6)
    lam = observer.multipliers(setup.contacts, state.q, 0.0)
    np.testing.assert_allclose(lam, state.lam, atol=1e-5)


@pytest.mark.parametrize("name", ["press", "tray"])
def test_an_observer_may_begin_with_a_robot_that_is_not_at_rest(name):
    """Not balanced by its torques, and moving: the forces are those that the rigid engine finds."""
    scenario = read_scenario(name, ["duration=0.3"])
    setup = build_setup(scenario)
    plant, _ = assemble_plant(scenario, setup, starting_posture(scenario, setup))
    robot, tau, state = setup.robot, np.zeros(setup.robot.na), plant.engine.state
    for _ in range(5):  # its arms fall
        before, state = state, plant.write(tau, state, None)
    assert np.abs(before.v).max() > 0.1
    observer, held = WrenchObserver(robot, 0.004), setup.schedule.at(before.t)
    observer.begin(held, before.q, before.v, tau, before.t)
    lam = observer.multipliers(held, before.q, before.t)
    acts = np.concatenate([state.lam[setup.contacts.rows[one.name]] for one in held.contacts])
    np.testing.assert_allclose(lam, acts, atol=0.01 * np.abs(acts).max())
    at_rest = WrenchObserver(robot, 0.004)
    at_rest.step(0.0, before.q, before.v, tau)
    worse = at_rest.multipliers(held, before.q, before.t) - acts
    assert np.abs(worse).max() > 10.0 * np.abs(lam - acts).max()


@pytest.mark.parametrize("filter_time", [0.004, 0.008])
def test_the_observer_is_a_low_pass_of_the_forces(filter_time):
    """Compared on true states with the same low-pass of the multipliers that the engine gave."""
    observer, slow, errors, sizes = None, None, [], []
    for _, true, controller in driven(blind=False):
        contacts = controller.schedule.at(0.0)
        J = contacts.jacobian(controller.robot.at(true.q))
        if observer is None:
            observer = WrenchObserver(controller.robot, filter_time)
            force = observer.step(0.0, true.q, true.v, true.tau)
            slow = force.copy()
            continue
        force = observer.step(1e-3, true.q, true.v, true.tau)
        slow += (J.T @ true.lam - slow) * 1e-3 / (filter_time + 1e-3)
        errors.append(np.linalg.norm(force - slow))
        sizes.append(np.linalg.norm(J.T @ true.lam))
    assert max(errors[20:]) < 0.01 * max(sizes)


def test_a_robot_is_driven_on_estimates():
    modes, apart, fast = set(), [], []
    for state, true, controller in driven():
        modes.add(controller.supervisor.mode.name)
        apart.append(pin.difference(controller.robot.model, true.q, state.q)[:6])
        fast.append(state.v[:6] - true.v[:6])
    assert modes == {"RUN"}
    assert np.abs(apart).max() < 1e-4
    assert np.abs(fast).max() < 5e-3


def test_a_run_logs_how_sure_the_estimate_is():
    scenario = read_scenario("press", ["duration=0.05"])

    def connect(controls, model):
        setup = controls.setup
        plant, tau = assemble_plant(scenario, setup, controls.q_start)
        behind = Blind(SimulatedRobot(plant, scenario.control.period, tau))
        return EstimatingRobot(behind, setup.robot, setup.contacts, setup.schedule)

    run = RemoteRun(scenario, connect, lockstep=True, prepared=prepared())
    spreads = np.array([record["estimate"].copy() for _, record in run.ticks()])
    assert len(spreads) == 50
    assert (spreads > 0.0).all()
    assert (spreads[:, 0] < 0.01).all()


def test_sensors_that_err_are_borne():
    noise = (
        "sensors={joint_position: {noise: 2.0e-5, bias: 2.0e-4}, joint_velocity: {noise: 1.0e-3},"
        " base_rate: {noise: 2.0e-3, bias: 1.0e-2}}"
    )
    apart = []
    for state, _, controller in driven(noise):
        apart.append(pin.difference(controller.robot.model, prepared().q_start, state.q)[:6])
        assert controller.supervisor.mode.name == "RUN"
    assert np.abs(apart).max() < 0.02


def test_the_same_moment_twice_is_counted_once():
    scenario = read_scenario("press", ["duration=0.3"])
    setup = build_setup(scenario, prepared().robot)
    plant, tau = assemble_plant(scenario, setup, prepared().q_start)
    behind = Blind(SimulatedRobot(plant, 1e-3, tau))
    once = behind.read(0.0)
    behind.read = lambda timeout: once
    robot = EstimatingRobot(behind, setup.robot, setup.contacts, setup.schedule)
    first, variance = robot.read(0.0), robot.base.variance.copy()
    second = robot.read(0.0)
    np.testing.assert_array_equal(first.q, second.q)
    np.testing.assert_array_equal(first.lam, second.lam)
    np.testing.assert_array_equal(variance, robot.base.variance)


def parts_of(name: str):
    """Yield each contact of a scenario, its kinematics, rows and own part."""
    scenario = read_scenario(name, ["duration=0.3"])
    setup = build_setup(scenario)
    kin = setup.robot.at(starting_posture(scenario, setup))
    for contact in setup.contacts.contacts:
        rows, (own,) = WrenchRows(setup.robot, ContactStack([contact])).at(kin.q, kin.t)
        yield contact, kin, rows, own


@pytest.mark.parametrize("name", ["press", "tray"])
def test_what_a_contact_does_by_its_own_rows_is_found_again(name):
    rng = np.random.default_rng(0)
    for contact, kin, rows, own in parts_of(name):
        lam = rng.normal(size=contact.size)
        force = contact.jacobian(kin).T @ lam
        wrench, left = np.linalg.lstsq(rows.T, force, rcond=None)[:2]
        assert np.abs(rows.T @ wrench - force).max() < 1e-9, left
        np.testing.assert_allclose(own @ wrench, lam, atol=1e-9)


def test_rubbing_is_no_pressing():
    """A force along the wall and any moment are not in the multiplier of a palm."""
    contact, _, _, own = next(part for part in parts_of("press") if part[0].name == "press")
    normal = contact.T_world_surface.rotation[:, 2]
    along = np.cross(normal, [0.3, -0.2, 0.9])
    assert np.abs(own @ np.concatenate((along, [4.0, 5.0, -6.0]))) < 1e-9
    assert own @ np.concatenate((2.0 * normal, np.zeros(3))) == pytest.approx(2.0)


def test_what_hands_carry_together_is_no_squeeze():
    """The same force, at the same place, on both hands."""
    contact, kin, _, own = next(part for part in parts_of("tray") if part[0].name == "grasp")
    T_a, T_b = kin.placement(contact.frame_a), kin.placement(contact.frame_b)
    force, moment = np.array([1.0, -2.0, 3.0]), np.array([0.4, 0.5, 0.6])
    at_a = moment + np.cross(T_b.translation - T_a.translation, force)
    assert np.abs(own @ np.concatenate((force, at_a, force, moment))).max() < 1e-12


def test_a_palm_that_rubs_in_mujoco_presses_as_it_is_estimated():
    """With one row for the palm the mean was off by 1.1 N of 20."""
    off, true = [], []
    changes = "physics.engine=mujoco", "duration=1.5", "control.period=0.002"
    for state, was, _ in driven(*changes, armature=True):
        off.append(state.lam[-1] - was.lam[-1])
        true.append(was.lam[-1])
    assert np.mean(true[-300:]) > 5.0
    assert abs(np.mean(off[-300:])) < 0.02 * np.mean(true[-300:])
