"""The clock of the targets: it waits for a robot that cannot follow, and lets go smoothly."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise import ControlGains, ControlSettings, RigidContactEngine, WholeBodyController
from equipoise.contacts import ContactSchedule, ContactStack, PointContact
from equipoise.control import Mode, SignFunction, advise_gains
from equipoise.errors import InputError
from equipoise.motion import Governor
from equipoise.tasks import ContactTask, FramePoseTask, JointAccelerationsTask, PostureTask
from equipoise.trajectories import Waypoint, WaypointTrajectory
from helpers import sole_contacts

DT = 1e-3


def hand_way(robot, shift, start, end):
    """Return a way of the left palm by `shift` [m] from where it is at half-sitting."""
    T = robot.at(robot.q_half_sitting).placement("left_palm")
    goal = pin.SE3(T.rotation, T.translation + np.array(shift))
    return WaypointTrajectory([Waypoint(start, T), Waypoint(end, goal)])


def make(robot, way, governor, *, bounded=False):
    q = robot.q_half_sitting
    contacts = ContactStack(sole_contacts(robot, q))
    levels = [
        [ContactTask("contacts", contacts)],
        [FramePoseTask("hand", "left_palm", way)],
        [PostureTask("posture", robot, q[7:])],
    ]
    if bounded:
        a = np.full(robot.na, 4.0)
        levels.insert(1, [JointAccelerationsTask("accelerations", robot, a, DT)])
    K_d = advise_gains(robot, contacts, q, DT, alpha=20.0).K_d
    gains = ControlGains(K_d=K_d, sgn_p=SignFunction("saturation", 0.05))
    settings = ControlSettings(gains, DT, governor=governor)
    return WholeBodyController(robot, levels, contacts, settings, q), contacts


def follow(controller, contacts, seconds):
    """Let the robot be where its reference is; return what the commands and the clock said."""
    state, tasks = controller.workspace.parts["reference"], controller.workspace.parts["tasks"]
    lam, v, rates = np.zeros(contacts.size), [], []
    for k in range(round(seconds / DT)):
        command = controller.step(k * DT, state.q.copy(), tasks.v_ref.copy(), lam)
        v.append(command.v_ref.copy())
        rates.append(controller.clock[0])
    return np.array(v), np.array(rates)


def test_a_robot_that_follows_sees_no_difference(hrp2):
    way = hand_way(hrp2, [0.1, 0.0, 0.1], 0.1, 1.0)
    free, _ = follow(*make(hrp2, way, None), 1.2)
    controller, contacts = make(hrp2, way, Governor())
    governed, rates = follow(controller, contacts, 1.2)
    np.testing.assert_allclose(governed, free, atol=1e-9)
    assert np.all(rates == 1.0)
    assert controller.clock[1] == pytest.approx(1.2)


def test_targets_wait_at_the_end_of_the_reach(hrp2):
    """The frame is never further behind than where the clock stands; nothing runs away."""
    way = hand_way(hrp2, [1.5, 0.0, 0.2], 0.2, 4.0)
    governor = Governor(way=(0.01, 0.03), fall=0.1, rise=0.5)
    controller, contacts = make(hrp2, way, governor, bounded=True)
    hand = controller.motion.levels[2][0]
    _, rates = follow(controller, contacts, 4.0)
    assert rates.min() >= 0.0
    assert rates[-500:].max() < 0.5
    steps = np.diff(rates) / DT
    assert steps.min() >= -1.0 / 0.1 - 1e-6
    assert steps.max() <= 1.0 / 0.5 + 1e-6
    late = controller.clock[1]
    assert late < 3.0
    behind = hand.error(hrp2.at(controller.motion.q_ref), late)
    assert np.linalg.norm(behind[:3]) < 0.06
    assert np.linalg.norm(hand.error(hrp2.at(controller.motion.q_ref), 4.0)[:3]) > 0.2


def run_blocked(robot, governor):
    """Hold the hand where it is from 1.0 to 2.2 s by a stiff spring; return what happened."""
    way = hand_way(robot, [0.15, 0.0, 0.2], 0.5, 2.5)
    controller, contacts = make(robot, way, governor)
    engine = RigidContactEngine(robot, contacts, robot.q_half_sitting, DT)
    held, seen = None, []
    for k in range(4500):
        t, state = k * DT, engine.state
        kin = robot.at(state.q, state.v)
        p, J = kin.placement("left_palm").translation, kin.jacobian("left_palm")[:3]
        force = np.zeros(3)
        if 1.0 <= t < 2.2:
            held = p.copy() if held is None else held
            force = -20000.0 * (p - held) - 200.0 * (J @ state.v)
        engine.external[:] = J.T @ force
        command = controller.step(t, state.q, state.v, state.lam)
        assert controller.law is not None
        integral = np.abs(controller.law.posture.memory[1]).max()
        speed, effort = np.abs(state.v).max(), np.abs(command.tau / robot.tau_max).max()
        seen.append((t, np.linalg.norm(force), integral, speed, effort))
        if controller.supervisor.mode is not Mode.RUN:
            return controller, np.array(seen), np.inf
        engine.step(command.tau)
    end = robot.at(engine.state.q).placement("left_palm").translation
    gap = float(np.linalg.norm(way.at(controller.clock[1]).T_world_target.translation - end))
    return controller, np.array(seen), gap


@pytest.mark.slow
def test_a_blocked_robot_finds_its_reference_waiting(hrp2):
    """A hand is held for 1.2 s: with the governor it goes on then, without the law is lost."""
    controller, seen, gap = run_blocked(hrp2, Governor())
    t, force, integral, speed, effort = seen.T
    blocked, after = (t >= 1.0) & (t < 2.2), t >= 2.2
    assert controller.supervisor.mode is Mode.RUN
    assert force[blocked].max() < 400.0
    assert integral[blocked].max() < 0.3  # 1.2 s of it unchecked would be 1.2
    assert speed[after].max() < 4.0
    assert effort.max() < 1.0
    assert gap < 1e-3
    assert 4.5 - controller.clock[1] > 1.0  # it waited
    assert controller.clock[0] == 1.0  # and goes on
    lost, _, _ = run_blocked(hrp2, None)
    assert lost.supervisor.mode is not Mode.RUN


def test_its_memory_is_part_of_the_state(hrp2):
    way = hand_way(hrp2, [1.5, 0.0, 0.2], 0.1, 0.6)
    controller, contacts = make(hrp2, way, Governor(), bounded=True)
    follow(controller, contacts, 0.3)
    kept, clock = controller.state(), controller.clock
    assert 0.0 <= clock[0] < 1.0
    state, tasks = controller.workspace.parts["reference"], controller.workspace.parts["tasks"]
    lam = np.zeros(contacts.size)

    def go_on():
        return [
            controller.step(0.3 + k * DT, state.q.copy(), tasks.v_ref.copy(), lam).result.copy()
            for k in range(20)
        ]

    first = go_on()
    controller.restore(kept)
    assert controller.clock == clock
    np.testing.assert_array_equal(first, go_on())


def test_contacts_that_come_and_go_are_refused(hrp2):
    q = hrp2.q_half_sitting
    soles = sole_contacts(hrp2, q)
    p = hrp2.at(q).placement("left_palm").translation
    push = PointContact(name="push", frame="left_palm", p_world=p)
    schedule = ContactSchedule([*soles, push], {"push": (0.5, 1.0)})
    levels = [[ContactTask("contacts", schedule)]]
    settings = ControlSettings(ControlGains(K_d=1.0), DT, governor=Governor())
    with pytest.raises(InputError, match="contacts come and go by the time"):
        WholeBodyController(hrp2, levels, schedule, settings, q)


@pytest.mark.parametrize(
    "wrong",
    [{"way": (0.03, 0.01)}, {"turn": (0.0, 0.1)}, {"posture": (0.1, np.nan)}, {"fall": -1.0}],
)
def test_limits_that_are_none_are_refused(wrong):
    with pytest.raises(InputError, match="governor"):
        Governor(**wrong)
