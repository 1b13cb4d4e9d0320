"""Live targets out of reach: the arm stretches and waits, the robot stands, the hand comes back."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise import LoopSettings, RigidContactEngine, WholeBodyController
from equipoise.control.modes import Mode
from equipoise.errors import InputError
from equipoise.motion import live_reach
from equipoise.robots import get_robot
from equipoise.tasks import FramePoseTask
from equipoise.trajectories import LiveTarget
from helpers import with_rotors

ROTORS = 0.05  # [kg m^2]
AWAY, BACK, END = 0.2, 8.0, 20.0  # [s] when the target is set, called back, and looked at


# robot, way [m], period [s], margin of the balance [m]: with 2 cm G1's ankles come to their limit
CASES = [
    ("hrp2", 0.8, 0.002, 0.02),
    ("g1", 0.8, 0.005, 0.05),
    ("romeo", 1.4, 0.005, 0.02),
    ("panda", 1.0, 0.001, 0.02),
]


@pytest.mark.parametrize(("name", "way", "dt", "margin"), CASES)
def test_a_hand_stretches_waits_and_comes_back(name, way, dt, margin):
    """Closed loop: three robots that stand, one that is bolted down; sent forward by a jump."""
    robot = get_robot(name)
    frame = robot.palms[-1].frame
    home = robot.at(robot.q_half_sitting).placement(frame).copy()
    far = pin.SE3(home.rotation, home.translation + np.array([way, 0.0, 0.0]))
    target = LiveTarget(home, speed=0.5, acceleration=2.0)
    hand = FramePoseTask("hand", frame, target, reach=live_reach(robot, dt))
    door = WholeBodyController.standing if robot.nv_base else WholeBodyController.fixed
    loop = LoopSettings(period=dt, rotor_inertia=ROTORS, margin=margin)
    controller = door(robot, tasks=[hand], loop=loop)
    engine = RigidContactEngine(
        with_rotors(robot, ROTORS), controller.contacts, robot.q_half_sitting, dt
    )
    state, v_ref, waited = engine.state, [], home.translation
    for k in range(round(END / dt)):
        if k == round(AWAY / dt):
            hand.target = far
        if k == round(BACK / dt):
            waited = robot.at(state.q).placement(frame).translation.copy()
            hand.target = home
        command = controller.step(k * dt, state.q, state.v, state.lam)
        state = engine.step(command.tau)
        v_ref.append(command.v_ref[robot.nv_base :])
    speeds = np.array(v_ref)
    assert controller.supervisor.mode is Mode.RUN
    assert not controller.supervisor.changes
    assert np.linalg.norm(waited - home.translation) > 0.1
    assert np.linalg.norm(waited - far.translation) > 0.1
    at_rest = speeds[round((BACK - 0.5) / dt) : round(BACK / dt)]
    assert np.abs(at_rest).max() < 0.15
    assert np.abs(np.diff(speeds, axis=0)).max() / dt < 25.0
    back = robot.at(state.q).placement(frame).translation - home.translation
    assert np.linalg.norm(back) < 1e-3


def test_what_is_no_robot_does_not_reach():
    with pytest.raises(InputError, match="must be a Robot"):
        live_reach("hrp2", 0.005)
