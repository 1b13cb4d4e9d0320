"""Supports that change through the door of the whole controller, in closed loop and by name."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest

from equipoise import RigidContactEngine, WholeBodyController, get_robot
from equipoise.contacts import ContactStack, Phase, PhaseSettings, PointContact
from equipoise.control.passivity.manifold_kernels import INTEGRAL
from equipoise.errors import InputError, NameNotFoundError
from equipoise.tasks import FramePoseTask
from equipoise.trajectories import LiveTarget
from equipoise.wbc import LossGuard
from stepping import Stepper


@pytest.mark.parametrize("name", ["hrp2", "talos", "g1"])
def test_slow_steps_in_mujoco(name):
    """A foot is unloaded, lifted by 5 cm, put down ahead and loaded; no torque jumps or clamps."""
    stepper = Stepper(get_robot(name))
    stepper.rest(0.2)
    stepper.step(1, forward=0.1)
    stepper.shift(stepper.middle[:2])
    stepper.rest(0.2)
    found, record = stepper.summary(), stepper.record
    assert found["base_mm"] <= 2.0
    assert found["joints_mrad"] <= 15.0
    assert found["switch_jump"] <= 1e-6
    assert found["share"] < 1.0
    lifted = np.array(record.loads)[:, 1] < 1.0
    assert 1.0 < lifted.sum() * stepper.dt < 1.3  # [s] in the air
    weight = stepper.robot.mass * 9.81
    assert np.allclose(np.sum(record.loads[-1]), weight, rtol=0.01)
    assert np.allclose(record.loads[-1] / weight, 0.5, atol=0.05)


def standing(robot, **given):
    """Return a controller of a robot on two soles, and an engine whose floor does not give."""
    controller = WholeBodyController.standing(robot, **given)
    engine = RigidContactEngine(robot, controller.contacts, robot.q_half_sitting, controller.dt)
    controller.take_over(engine.stand())
    return controller, engine


def run(controller, engine, ticks, start=0):
    """Run; return the commands."""
    found = []
    for tick in range(start, start + ticks):
        state, rows = engine.state, engine.contacts.rows
        lam = {name: state.lam[rows[name]] for name in controller.supports.at(0.0).rows}
        found.append(controller.step(tick * controller.dt, state.q, state.v, lam))
        engine.step(found[-1].tau)
    return found


def test_the_reference_lets_the_foot_go_that_does_not_support(hrp2):
    """A contact task holds the feet that support; a foot that was let go is free to follow."""
    T = hrp2.at(hrp2.q_half_sitting).placement("right_sole")
    target = LiveTarget(T, fade=0.05)
    foot = FramePoseTask("foot", "right_sole", target)
    controller, engine = standing(hrp2, tasks=[foot])
    run(controller, engine, 3)
    up = pin.SE3(T.rotation, T.translation + np.array([0.0, 0.0, 0.02]))

    def height():
        q_ref = controller.workspace.parts["reference"].q.copy()
        return hrp2.at(q_ref).placement("right_sole").translation[2] - T.translation[2]

    def ask(ticks, start):
        state = engine.state
        for tick in range(start, start + ticks):
            lam = np.zeros(controller.supports.at(0.0).size)
            controller.step(tick * controller.dt, state.q, state.v, lam)

    target.set(up)
    ask(100, 3)
    assert abs(height()) < 1e-4
    controller.switch(["left_sole"])
    ask(100, 103)
    assert controller.contacts.rows.keys() == {"left_sole"}
    lifted = height()
    assert lifted > 0.01
    controller.switch(["left_sole", "right_sole"])
    ask(100, 203)
    assert abs(height() - lifted) < 1e-4  # it holds where the reference had it, not where it was
    anchor = controller.supports.contacts["right_sole"].T_world_anchor
    assert anchor.translation[2] - T.translation[2] == pytest.approx(lifted, abs=1e-4)


def test_a_switch_is_part_of_the_memory(hrp2):
    controller, engine = standing(hrp2)
    run(controller, engine, 3)
    T = hrp2.at(hrp2.q_half_sitting).placement("right_sole")
    moved = pin.SE3(pin.utils.rotate("z", 0.1) @ T.rotation, T.translation)
    state = engine.state

    def go_on():
        controller.switch(["left_sole", "right_sole"], anchors={"right_sole": moved})
        lam = np.linspace(0.0, 300.0, 12)
        return controller.step(0.004, state.q, state.v, lam).tau.copy()

    controller.switch(["left_sole"], "energy")
    kept = pickle.loads(pickle.dumps(controller.state()))
    controller.step(0.003, state.q, state.v, state.lam[:6])
    first = go_on()
    controller.restore(kept)
    assert controller.contacts.rows.keys() == {"left_sole", "right_sole"}  # not yet switched
    controller.step(0.003, state.q, state.v, state.lam[:6])
    assert controller.contacts.rows.keys() == {"left_sole"}
    assert (go_on() == first).all()
    again = controller.state()
    controller.restore(kept)
    controller.restore(again)
    anchor = controller.supports.contacts["right_sole"].T_world_anchor
    assert np.allclose(anchor.rotation, moved.rotation)


def test_wrong_names_are_refused(hrp2):
    controller, _ = standing(hrp2)
    with pytest.raises(NameNotFoundError, match="left_sole"):
        controller.switch(["left_soul"])
    with pytest.raises(InputError, match="no contact is left"):
        controller.switch([])
    with pytest.raises(NameNotFoundError, match="wall"):
        controller.switch(["left_sole"], others=["wall"])
    with pytest.raises(NameNotFoundError, match="left_soul"):
        controller.switch(["left_sole"], anchors={"left_soul": pin.SE3.Identity()})
    with pytest.raises(InputError, match="kept"):
        controller.switch(["left_sole"], "momentum")
    assert controller.contacts.rows.keys() == {"left_sole", "right_sole"}


@pytest.mark.parametrize("keep", ["energy", "torque"])
def test_a_floor_that_gives_way_under_a_loaded_foot_is_survived(hrp2, keep):
    """Nobody planned it: the phases tell it, the controller goes over to the other foot."""
    controller, engine = standing(hrp2)
    guard = LossGuard(controller, PhaseSettings.for_weight(9.81 * hrp2.mass), keep)
    run(controller, engine, 200)
    names = ["left_sole", "right_sole"]
    both = controller.supports.at(0.0)
    state = engine.state
    assert state.lam[8] > 0.4 * 9.81 * hrp2.mass
    alone = ContactStack(both.contacts[:1])
    engine = RigidContactEngine(hrp2, alone, state.q, controller.dt, v_start=state.v)
    lam, worst, held = state.lam.copy(), 0.0, names
    for tick in range(200, 1200):
        t, state = tick * controller.dt, engine.state
        measured = {"left_sole": state.lam if tick > 200 else lam[:6], "right_sole": np.zeros(6)}
        held = guard.update(t, names, measured)
        command = controller.step(t, state.q, state.v, {name: measured[name] for name in held})
        dq = pin.difference(hrp2.model, command.q_ref, state.q)
        worst = max(worst, float(np.abs(dq[6:]).max()))
        engine.step(command.tau)
    assert held == ["left_sole"]
    assert [change.phase for change in guard.story] == [Phase.LOST]
    assert guard.story[0].t == pytest.approx(0.202)
    assert worst < 0.25
    assert np.abs(dq[6:]).max() < 0.02  # and back


def test_a_hand_is_let_go_and_taken_again_without_a_jump(hrp2):
    """Contacts beside the supports come and go by name; the supports stay who they are."""
    palm = hrp2.palms[1].frame
    p_world = hrp2.at(hrp2.q_half_sitting).placement(palm).translation
    hand = PointContact("hand", regulated=("fx",), frame=palm, p_world=p_world)
    controller, engine = standing(hrp2, contacts=[hand], forces={"hand": 5.0})
    *_, one, before = (command.tau for command in run(controller, engine, 50))
    feet = ["left_sole", "right_sole"]
    for others, start in (([], 50), (["hand"], 60), ([], 70)):
        usual = np.abs(before - one).max()  # from tick to tick
        controller.switch(feet, others=others)
        first, *_, one, last = (command.tau for command in run(controller, engine, 10, start))
        assert list(controller.contacts.rows) == [*feet, *others]
        assert np.abs(first - before).max() < 2.0 * usual
        before = last
    controller.switch(feet[:1])  # the hand stays as it was: away
    run(controller, engine, 1, 80)
    assert list(controller.contacts.rows) == feet[:1]


def test_noise_of_a_moment_does_not_stay_where_a_support_goes(hrp2, rng):
    """Velocities that are wrong for two ticks: the torque follows them, what is learned does not.

    Without the noise there is nothing to leave out: the torque is continuous all the same.
    """

    def lifted(noise):
        controller, engine = standing(hrp2)
        run(controller, engine, 30)
        state, rows = engine.state, engine.contacts.rows
        lam = {name: state.lam[rows[name]] for name in rows}
        dt = controller.dt
        before = controller.step(30 * dt, state.q, state.v + noise, lam)
        controller.switch(["left_sole"])
        after = controller.step(31 * dt, state.q, state.v + noise, {"left_sole": lam["left_sole"]})
        gains = controller.settings.gains
        learned = controller.workspace.parts["law"].posture[INTEGRAL]
        return before.tau, after.tau, gains.k_ip * gains.K_d @ learned

    quiet, still, learned = lifted(np.zeros(hrp2.nv))
    assert np.abs(still - quiet).max() < 1e-9
    noise = np.concatenate((np.zeros(6), 0.01 * rng.standard_normal(hrp2.na)))
    loud, kept, noisy = lifted(noise)
    wrong = np.abs(loud - quiet).max()  # [N m]
    assert wrong > 0.3
    assert np.abs(kept - loud).max() < 1e-9  # both ticks were wrong alike: continuous again
    assert np.abs(noisy - learned)[6:].max() < 0.4 * wrong
