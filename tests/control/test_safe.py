"""Safe means safe: the base found by the contacts, the posture held, and the way back."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

from equipoise.compiled.workspace import Workspace
from equipoise.contacts import ContactStack
from equipoise.control import Mode, SupervisorLimits
from equipoise.control.found_by_contacts import FoundByContacts, found_by_contacts
from equipoise.control.passivity.gain_advice import inertia_matrix, random_postures
from equipoise.control.safe_hold import DAMPING_SHARE, damping_of_all, joint_damping
from equipoise.errors import InputError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import get_robot
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation
from helpers import sole_contacts

ROBOTS = ("hrp2", "talos", "g1", "romeo")
LATE = ("faults.measurement_delay=0.003", "faults.command_delay=0.002")


def silence(sensor: str, start: float, end: float) -> str:
    return f"faults.silences=[{{sensor: {sensor}, start: {start}, end: {end}, reading: nan}}]"


def press(robot: str, engine: str, *overrides: str) -> Simulation:
    given = [f"physics.engine={engine}", *overrides]
    return Simulation(read_scenario("press", given, robot=None if robot == "hrp2" else robot))


def watched(simulation: Simulation) -> dict[str, np.ndarray]:
    """Run; return height and speed of the base, largest share of a joint's speed, mode, torque."""
    kept: dict[str, list[np.ndarray]] = {name: [] for name in ("z", "vz", "fastest", "mode", "tau")}
    for _, record in simulation.ticks():
        q, v = record["q"], record["v"]
        share = (np.abs(v[6:]) / simulation.robot.v_max).max()
        values = q[2], abs(v[2]), share, record["mode"][0], record["tau"].copy()
        for name, value in zip(kept, values, strict=True):
            kept[name].append(np.array(value))
    return {name: np.array(values) for name, values in kept.items()}


@pytest.mark.parametrize("name", ["hrp2", "g1"])
def test_the_base_is_found_where_the_soles_say_it_is(name, rng):
    """Move joints and base so that the soles stay; forget the base; find it again, and its v."""
    robot = get_robot(name)
    q = robot.q_half_sitting.copy()
    stack = ContactStack(sole_contacts(robot, q))
    for _ in range(40):  # a motion on the tangent space, its drift taken back
        kin = robot.at(q)
        at = stack.at(kin)
        v = at.project(rng.normal(size=robot.nv))
        q = pin.integrate(robot.model, q, 2e-3 * v - at.lift(stack.residual(kin)))
    v = stack.at(robot.at(q)).project(rng.normal(size=robot.nv))
    blind_q, blind_v = q.copy(), v.copy()
    blind_q[:7], lost = robot.q_half_sitting[:7], np.arange(robot.nv) < 6
    blind_v[:6] = 0.0
    even, kinematics = np.full(2, 0.5), KinematicsEvaluator(robot)
    found = found_by_contacts(
        robot, stack, robot.q_half_sitting, (blind_q, blind_v), (lost, even), kinematics
    )
    assert found is not None
    apart = pin.difference(robot.model, q, found[0])
    assert np.abs(apart).max() < 1e-5
    assert found[1] == pytest.approx(v, abs=1e-5)


def test_without_a_contact_no_base_is_made_up(hrp2):
    q, v = hrp2.q_half_sitting, np.zeros(hrp2.nv)
    lost, nothing = np.arange(hrp2.nv) < 6, ContactStack([])
    whole, kinematics = (q, v), KinematicsEvaluator(hrp2)
    assert found_by_contacts(hrp2, nothing, q, whole, (lost, np.zeros(0)), kinematics) is None
    found = FoundByContacts(hrp2, 1e-3, 0.01)
    assert found.follow(nothing, whole, whole, lost, np.zeros(0)) is None


@pytest.mark.parametrize("delay", [0.001, 0.005, 0.02])
@pytest.mark.parametrize("name", ROBOTS)
def test_damping_is_stable_for_every_joint_at_its_delay(name, delay):
    """dv/dt = -M^-1 D v(t - delay), the robot afloat: stepped, not by eigenvalues."""
    robot = get_robot(name)
    M = pin.crba(robot.model, robot.model.createData(), robot.q_half_sitting)
    M = np.triu(M) + np.triu(M, 1).T
    D = joint_damping(robot, robot.q_half_sitting, delay)
    least = 1.0 / np.diag(np.linalg.inv(M))[6:]
    assert D * delay / least == pytest.approx(DAMPING_SHARE)
    for joint in range(robot.na):
        v = np.zeros(41)  # the last delay, 40 steps of it
        v[-1] = 1.0
        for _ in range(400):
            v = np.append(v[1:], v[-1] - delay / 40 * D[joint] / least[joint] * v[0])
        assert abs(v[-1]) < 0.1


@pytest.mark.parametrize("name", ROBOTS)
def test_sinking_is_damped_stably_in_every_posture_whatever_touches(name, rng):
    """dv/dt = -W D v(t - late) of all joints at once, stepped; free, and with random contacts.

    The damping of half-sitting would be lost there: it is the posture of the moment that counts.
    """
    robot, late, lost = get_robot(name), 0.0065, 0
    fixed = joint_damping(robot, robot.q_half_sitting, late)
    for q in random_postures(robot, robot.q_half_sitting, 4, seed=3):
        M = inertia_matrix(robot, q)
        W = np.linalg.inv(M)[6:, 6:]
        D = damping_of_all(M, 6, late)
        J = rng.normal(size=(6, robot.nv))
        held = np.linalg.inv(M)
        held = held - held @ J.T @ np.linalg.solve(J @ held @ J.T, J @ held)
        for inverse in (W, held[6:, 6:]):
            assert swings_out(inverse, D, late, rng)
        lost += not swings_out(W, fixed, late, rng)
    assert name != "g1" or lost


def swings_out(W: np.ndarray, D: np.ndarray, late: float, rng: np.random.Generator) -> bool:
    """Step dv/dt = -W D v(t - late), in coordinates sqrt(D) v; tell whether it becomes smaller."""
    A = np.sqrt(D)[:, None] * W * np.sqrt(D)
    past = [rng.normal(size=len(A))] * 21  # the last delay, 20 steps of it
    first = np.linalg.norm(past[-1])
    for _ in range(400):
        past = [*past[1:], past[-1] - late / 20 * A @ past[0]]
    return bool(np.linalg.norm(past[-1]) < first)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["rigid", "mujoco"])
@pytest.mark.parametrize("name", ROBOTS)
def test_a_base_sensor_that_comes_back_brings_the_run_back(name, engine):
    """Lost for 0.4 s: held, back over a ramp, never below 99 % of its height."""
    simulation = press(name, engine, "duration=2.0", silence("base", 0.5, 0.9))
    run = watched(simulation)
    story = " ".join(simulation.story)
    assert "no measurement of the base" in story
    assert "back to the reference" in story
    assert run["mode"].max() == 2  # it was safe,
    assert run["mode"][-1] == 0  # and it runs again
    assert run["z"].min() > 0.98 * run["z"][0]
    assert run["fastest"].max() < 1.0
    limit = simulation.robot.tau_max
    jumps = max((np.abs(b - a) / limit).max() for a, b in pairwise(run["tau"][450:]))
    assert jumps < 0.25


@pytest.mark.slow
def test_a_hand_on_a_wall_stays_there_without_a_base():
    """Lost for good while the force still rises: the hand goes on pressing as it did."""
    simulation = press("hrp2", "rigid", "duration=2.0", silence("base", 0.6, 9.0))
    run = watched(simulation)
    safe = run["mode"] == 2
    assert run["mode"][-1] == 2
    assert len(simulation.controller.supervisor.changes) == 2  # degraded, safe: it never sank
    assert run["fastest"][safe].max() < 0.3
    held = simulation.controller.supervisor.safe.pressed[-1]
    assert held == pytest.approx(18.6, rel=0.02)  # of the profile when it was made safe
    assert simulation.engine.state.lam[-1] == pytest.approx(held, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hrp2", "g1"])
def test_a_law_that_is_given_up_leaves_a_hand_on_its_wall(name):
    """Everything is measured, somebody has had enough: the robot stands still."""
    simulation = press(name, "rigid", "duration=2.0")
    fastest, supervisor = 0.0, simulation.controller.supervisor
    for t, record in simulation.ticks():
        if t >= 0.6:
            supervisor.give_up(t, "enough of it")
            fastest = max(fastest, np.abs(record["v"][6:]).max())
    assert supervisor.mode is Mode.SAFE
    assert len(supervisor.changes) == 1
    assert fastest < 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "at"), [("hrp2", 0.6), ("talos", 0.82), ("g1", 0.6), ("romeo", 0.5)]
)
def test_without_a_base_and_five_milliseconds_late_it_stands(name, at):
    """Lost for good in MuJoCo, while the arm is fast: the posture is held as long as one looks."""
    run = watched(press(name, "mujoco", "duration=2.2", *LATE, silence("base", at, 9.0)))
    assert run["mode"][-1] == 2
    safe = run["mode"] == 2
    assert run["z"][-1] > 0.97 * run["z"][0]
    assert run["vz"][safe].max() < 0.5
    assert run["fastest"][safe].max() < 1.0
    signs = np.sign(run["tau"][safe])
    assert (signs[1:] != signs[:-1]).mean(axis=0).max() < 0.05  # no torque flips tick by tick


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hrp2", "talos"])
def test_a_law_that_its_delay_makes_swing_is_caught_standing(name):
    """Gains for no delay and a loop 5 ms late: joints run away, SAFE stops them."""
    simulation = press(name, "rigid", "duration=1.5", *LATE)
    run = watched(simulation)
    assert "moves at" in " ".join(simulation.story)
    assert run["z"].min() > 0.9 * run["z"][0]
    assert run["fastest"][-200:].max() < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("delay", [(), LATE])
def test_an_arm_that_is_stopped_does_not_go_looking_for_what_it_was_to_touch(delay):
    """Stopped at 0.25 s; at 2.0 s the plate's window opens, and the hand is not there."""
    simulation = Simulation(read_scenario("arm_press", ["duration=2.6", *delay]))
    supervisor, moved = simulation.controller.supervisor, 0.0
    for t, record in simulation.ticks():
        if t >= 0.25:
            supervisor.give_up(t, "emergency stop")
        if t > 1.0:
            moved = max(moved, np.abs(record["v"]).max())
    assert len(supervisor.changes) == 1
    assert moved < 0.01


def test_beyond_the_time_of_recovery_there_is_no_way_back():
    simulation = press(
        "hrp2", "rigid", "duration=0.6", silence("base", 0.2, 0.5), "control.start=standing"
    )
    limits = SupervisorLimits(recovery=0.1)
    simulation.controller.supervisor.limits = limits
    run = watched(simulation)
    assert run["mode"][-1] == 2
    assert simulation.controller.supervisor.mode is Mode.SAFE


@pytest.mark.parametrize("wrong", [np.nan, -1.0, np.inf])
def test_limits_that_are_none_are_refused(wrong):
    with pytest.raises(InputError, match="recovery"):
        SupervisorLimits(recovery=wrong)


def test_a_hold_goes_on_from_its_state_with_the_same_bits():
    first = press("hrp2", "rigid", "duration=0.4", silence("base", 0.1, 9.0))
    second = press("hrp2", "rigid", "duration=0.4", silence("base", 0.1, 9.0))
    controller, other = first.controller, second.controller
    ticks = first.ticks()
    for _ in range(300):
        _, record = next(ticks)
    state = controller.state()
    other.restore(state)
    blind_q, blind_v = record["q"].copy(), record["v"].copy()
    blind_q[:7], blind_v[:6] = np.nan, np.nan
    lam = np.zeros(controller.contacts.size)
    for k in range(20):
        a = controller.step(0.3 + k * 1e-3, blind_q, blind_v, lam)
        b = other.step(0.3 + k * 1e-3, blind_q, blind_v, lam)
        assert np.array_equal(a.tau, b.tau)
        assert a.mode is Mode.SAFE


def test_a_bridged_tick_makes_no_memory(monkeypatch):
    """What is made once, a tick reuses: with memory made anew it took ten times its period."""
    simulation = press("g1", "rigid", "duration=0.2")
    controller, state = simulation.controller, simulation.engine.state
    blind_q, blind_v = state.q.copy(), state.v.copy()
    blind_q[:7], blind_v[:6] = np.nan, np.nan
    lam = np.full(controller.contacts.size, np.nan)
    controller.step(0.0, state.q, state.v, np.zeros_like(lam))
    controller.step(0.001, blind_q, blind_v, lam)
    made = []
    begin = Workspace.__init__
    monkeypatch.setattr(Workspace, "__init__", lambda *a, **k: (made.append(1), begin(*a, **k))[1])
    for k in range(2, 6):
        assert controller.step(1e-3 * k, blind_q, blind_v, lam).mode is Mode.DEGRADED
    assert not made


@pytest.mark.parametrize("name", ["hrp2", "g1"])
def test_a_loop_that_writes_into_one_array_is_held_where_it_was(name):
    """The same arrays every tick, the torque scaled in place; then the base is lost in them."""
    simulation = press(name, "rigid", "duration=0.2")
    controller, engine = simulation.controller, simulation.engine
    q, v = np.empty(simulation.robot.nq), np.empty(simulation.robot.nv)
    lam = np.zeros(controller.contacts.size)
    state, tau = engine.state, np.zeros(simulation.robot.na)
    for k in range(150):
        q[:], v[:] = state.q, state.v
        if k >= 100:
            q[:7], v[:6] = np.nan, np.nan
        command = controller.step(k * 1e-3, q, v, lam)
        tau[:] = command.tau
        assert np.isfinite(tau).all()
        lam[:] = simulation.plant.multipliers(simulation.plant.read(state), controller.contacts)
        command.tau[:] *= 1e6
        state = engine.step(tau)
    assert controller.supervisor.mode is Mode.SAFE
    assert "sinking" not in " ".join(controller.story)
    assert state.q[2] > 0.98 * simulation.assembly.q_start[2]
