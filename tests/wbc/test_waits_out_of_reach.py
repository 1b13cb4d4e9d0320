"""Who only sets a target, however far, has a robot that stands, waits stretched, and comes back."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise import InverseKinematics, LoopSettings, RigidContactEngine, WholeBodyController
from equipoise.control.modes import Mode
from equipoise.motion import live_reach
from equipoise.robots import get_robot, named_robots
from equipoise.robots.arm_span import arm_span
from equipoise.tasks import FramePoseTask
from helpers import with_rotors

ROTORS = 0.05  # [kg m^2]
AWAY, BACK, END = 0.2, 6.0, 18.0  # [s] when the target is set, called back, and looked at


def robot_named(name):
    if named_robots()[name].missing:
        pytest.skip(f"{name} is not installed")
    return get_robot(name)


def home_of(robot):
    frame = robot.palms[-1].frame
    return frame, robot.at(robot.q_half_sitting).placement(frame).copy()


@pytest.mark.parametrize(
    ("name", "way", "dt"),
    [
        ("hrp2", (1.2, 0.0, 0.5), 0.002),
        ("g1", (0.8, 0.0, 0.0), 0.005),
        ("romeo", (0.0, 0.0, 1.5), 0.005),
        ("panda", (0.0, 0.0, 1.3), 0.002),
    ],
)
def test_a_pose_far_away_is_waited_for_without_a_word(name, way, dt):
    """Closed loop, nothing said but the target."""
    robot = robot_named(name)
    frame, home = home_of(robot)
    hand = FramePoseTask("hand", frame, home)
    door = WholeBodyController.standing if robot.nv_base else WholeBodyController.fixed
    controller = door(robot, tasks=[hand], loop=LoopSettings(period=dt, rotor_inertia=ROTORS))
    engine = RigidContactEngine(
        with_rotors(robot, ROTORS), controller.contacts, robot.q_half_sitting, dt
    )
    state, v_ref, waited, told = engine.state, [], home.translation, {}
    for k in range(round(END / dt)):
        if k == round(AWAY / dt):
            hand.target = pin.SE3(home.rotation, home.translation + np.array(way))
        if k == round(BACK / dt):
            waited = robot.at(state.q).placement(frame).translation.copy()
            told = controller.out_of_reach
            hand.target = home
        command = controller.step(k * dt, state.q, state.v, state.lam)
        state = engine.step(command.tau)
        v_ref.append(command.v_ref[robot.nv_base :])
    speeds = np.array(v_ref)
    assert controller.supervisor.mode is Mode.RUN
    assert not controller.supervisor.changes
    assert np.linalg.norm(waited - home.translation) > 0.1
    missed = np.linalg.norm(home.translation + way - waited)
    assert told["hand"] > 0.9 * missed > 0.1
    assert np.abs(speeds[round((BACK - 0.5) / dt) : round(BACK / dt)]).max() < 0.3
    assert np.abs(np.diff(speeds, axis=0)).max() / dt < 201.0
    if robot.nv_base:
        assert state.q[2] > 0.9 * robot.q_half_sitting[2]
    end = robot.at(controller.motion.q_ref).placement(frame).translation
    assert np.linalg.norm(end - home.translation) < 0.1


@pytest.mark.parametrize("name", ["hrp2", "talos", "g1", "panda", "ur5"])
@pytest.mark.parametrize("dt", [0.001, 0.004])
def test_what_is_in_reach_is_followed_as_without_a_reach(name, dt):
    """A jump of 8 cm, then a circle: the same numbers, and nobody is told anything."""
    robot = robot_named(name)
    frame, home = home_of(robot)
    pulled = np.array([-0.05, 0.0, 0.06]) if not robot.nv_base else np.array([0.04, 0.02, 0.06])
    found = []
    for reach in (live_reach(robot, dt, frame=frame), False):
        hand = FramePoseTask("hand", frame, home, reach=reach)
        ik = InverseKinematics(robot, [hand], period=dt)
        v = []
        for k in range(round(2.0 / dt)):
            t = k * dt
            if t >= 0.2:
                angle = 2.0 * max(t - 1.0, 0.0)
                circle = 0.04 * np.array([0.0, np.sin(angle), 1.0 - np.cos(angle)])
                hand.target = pin.SE3(home.rotation, home.translation + pulled + circle)
            v.append(ik.step(t).v_ref)
        found.append(np.array(v))
        assert ik.motion.out_of_reach == {}
    assert np.abs(found[0]).max() > 0.1
    assert np.abs(found[0] - found[1]).max() < 1e-9


@pytest.mark.parametrize("name", ["hrp2", "talos", "g1", "romeo", "panda", "ur5"])
def test_the_span_of_an_arm_is_as_long_as_any_posture_makes_it(name):
    """Against 2,000 random postures; where the axes of a wrist meet, turning it changes nothing."""
    robot = robot_named(name)
    frame, _ = home_of(robot)
    span = arm_span(robot, frame, robot.q_half_sitting)
    rng, q, longest = np.random.default_rng(1), robot.q_half_sitting.copy(), 0.0
    for _ in range(2000):
        q[robot.nq_base :] = rng.uniform(robot.q_min, robot.q_max)
        kin = robot.at(q)
        wrist = kin.placement(frame).act(span.p_frame_wrist)
        far = np.linalg.norm(wrist - kin.joint_placement(span.shoulder).translation)
        longest = max(longest, float(far))
    assert longest <= span.longest + 1e-6
    assert longest > 0.95 * span.longest
    assert span.surely <= span.longest
    if name in ("hrp2", "talos", "romeo"):
        assert span.surely == pytest.approx(span.longest, abs=1e-3)


def test_a_reach_that_was_chosen_stays(hrp2):
    frame, home = home_of(hrp2)
    head = FramePoseTask("head", hrp2.camera, hrp2.at(hrp2.q_half_sitting).placement(hrp2.camera))
    exact = FramePoseTask("hand", frame, home, reach=False)
    other = FramePoseTask("other", "left_palm", home)
    WholeBodyController.standing(hrp2, tasks=[exact, head, other])
    assert other.reach is not None
    assert exact.reach is None
    assert head.reach is None  # no arm carries it


def test_the_memory_of_a_wait_is_the_controllers(hrp2):
    """Restored in the middle of a wait, it goes on to the bit."""
    frame, home = home_of(hrp2)
    dt = 0.005
    hand = FramePoseTask("hand", frame, home)
    controller = WholeBodyController.standing(hrp2, tasks=[hand], loop=LoopSettings(period=dt))
    q, v = hrp2.q_half_sitting, np.zeros(hrp2.nv)
    lam = np.zeros(controller.contacts.size)
    hand.target = pin.SE3(home.rotation, home.translation + np.array([1.0, 0.0, 0.0]))
    for k in range(600):
        controller.motion.step(k * dt)
    assert controller.out_of_reach["hand"] > 0.1
    kept = controller.state()
    ends = []
    for _ in range(2):
        controller.restore(kept)
        for k in range(600, 700):
            controller.motion.step(k * dt)
        ends.append(controller.motion.q_ref)
    np.testing.assert_array_equal(ends[0], ends[1])
    assert controller.step(3.5, q, v, lam) is not None


def test_what_has_an_ease_or_was_told_not_to_does_not_wait(hrp2):
    frame, home = home_of(hrp2)
    tasks = [
        FramePoseTask("waits", frame, home),
        FramePoseTask("eased", frame, home).easing(10.0),
        FramePoseTask("told", frame, home, reach=False),
    ]
    WholeBodyController.standing(hrp2, tasks=tasks)
    assert [task.reach is not None for task in tasks] == [True, False, False]
