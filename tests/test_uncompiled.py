"""There is one implementation: kernels run uncompiled give the same tick."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

CODE = """
import sys
import numpy as np
from equipoise.contacts import ContactStack, PointContact
from equipoise.control import ControlGains, Measurement, PassivityController, Target
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.physics import RigidContactEngine
from equipoise.robots import get_robot
from equipoise.contacts.support_polygon import SupportPolygon
from equipoise.tasks import (
    ComPolygonTask, ContactTask, FramePoseTask, GazeTask, JointLimitsTask, Waypoint,
    WaypointTrajectory,
)
sys.path.insert(0, sys.argv[2])
from helpers import sole_contacts
import pinocchio as pin
from equipoise.kinematics import KinematicsEvaluator

robot = get_robot("hrp2")
q = robot.q_half_sitting
kin = KinematicsEvaluator(robot).at(q, np.zeros(robot.nv))
palm = robot.frame_id("left_palm")
T = kin.placement(palm)
goal = pin.SE3(pin.exp3(np.array([0.1, 0.2, 0.0])) @ T.rotation, T.translation + 0.1)
hand = robot.frame_id("right_palm")
held = PointContact("hand", regulated=("fx",), frame_id=hand,
                    p_world=kin.placement(hand).translation)
contacts = ContactStack([*sole_contacts(robot, q), held])
way = WaypointTrajectory([Waypoint(0.0, T), Waypoint(0.5, goal)])
square = np.array([[-0.1, -0.2], [0.15, -0.2], [0.15, 0.2], [-0.1, 0.2]])
levels = [
    [ContactTask("contacts", contacts)],
    [ComPolygonTask("com", SupportPolygon.of_points(square)), JointLimitsTask("limits", robot)],
    [FramePoseTask("palm", palm, way), GazeTask("look", robot.frame_id(robot.camera), way)],
]
motion = MotionGenerator(robot, levels, make_solver("cascade"), 1e-3, q)
law = PassivityController(robot, contacts, ControlGains(K_d=10.0), 1e-3)
engine = RigidContactEngine(robot, contacts, q, 1e-3, joint_damping=0.5)
state, told = engine.state, []
for k in range(3):
    step = motion.step(k * 1e-3)
    target = Target(step.q_ref, step.v_ref, np.array([5.0]))
    command = law.step(k * 1e-3, Measurement(state.q, state.v, state.lam), target)
    state = engine.step(command.tau)
    told += [step.v_ref, command.s, command.tau, state.q, state.v, state.lam]
np.save(sys.argv[1], np.concatenate(told))
"""


@pytest.mark.slow
def test_uncompiled_kernels_give_the_same_ticks(tmp_path):
    answers = []
    for name, flag in (("compiled", "0"), ("plain", "1")):
        path = tmp_path / f"{name}.npy"
        subprocess.run(
            [sys.executable, "-c", CODE, str(path), str(Path(__file__).parent)],
            env={**os.environ, "NUMBA_DISABLE_JIT": flag},
            check=True,
        )
        answers.append(np.load(path))
    scale = np.maximum(1.0, np.abs(answers[0]))
    assert np.abs((answers[0] - answers[1]) / scale).max() < 1e-9
