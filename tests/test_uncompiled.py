"""There is one implementation: kernels run uncompiled give the same ticks."""

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
import pinocchio as pin
from equipoise import (
    ControlGains,
    ControlSettings,
    RigidContactEngine,
    WholeBodyController,
    get_robot,
)
from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import ContactSchedule, ContactStack, PointContact
from equipoise.contacts.support_polygon import SupportPolygon
from equipoise.control import ReactionBounds
from equipoise.physics import RigidOptions
from equipoise.spatial import pose
from equipoise.tasks import (AvoidanceTask, ComPolygonTask, ContactTask, FramePoseTask, GazeTask,
                             JointLimitsTask, PostureTask)
from equipoise.trajectories import Fade, Profile, Waypoint, WaypointTrajectory
sys.path.insert(0, sys.argv[2])
from helpers import sole_contacts

robot = get_robot("hrp2")
q = robot.q_half_sitting
kin = robot.at(q)
T = kin.placement("left_palm")
goal = pin.SE3(pin.exp3(np.array([0.1, 0.2, 0.0])) @ T.rotation, T.translation + 0.1)
held = PointContact("hand", regulated=("fx",), frame="right_palm",
                    p_world=kin.placement("right_palm").translation)
soles = sole_contacts(robot, q)
contacts = ContactSchedule([*soles, held], {"hand": (-np.inf, 0.002)})
path = WaypointTrajectory([Waypoint(0.0, T), Waypoint(0.5, goal)])
square = np.array([[-0.1, -0.2], [0.15, -0.2], [0.15, 0.2], [-0.1, 0.2]])
wall = Body("wall", (Shape("box", (0.05, 2.0, 3.0), pose((T.translation[0] + 0.15, 0, 0))),),
            pin.SE3.Identity())
scene = Scene(robot, [wall])
levels = [
    [ContactTask("contacts", contacts)],
    [ComPolygonTask("com", SupportPolygon.of_points(square)), JointLimitsTask("limits", robot),
     AvoidanceTask("near", scene, [scene.pair("LARM_LINK5", "wall")])],
    [FramePoseTask("palm", "left_palm", path), GazeTask("look", robot.camera, path)],
    [PostureTask("posture", robot, q[robot.nq_base:])],
]
told = []
for bounds in (None, ReactionBounds()):
    settings = ControlSettings(ControlGains(K_d=10.0), bounds=bounds)
    controller = WholeBodyController(
        robot, levels, contacts, settings, q, wanted_forces={"hand": [Profile.of([0, 1], [0, 20])]},
        fades={"look": Fade(0.001, 1.0, 0.002)},
    )
    stacks = {stack.size: RigidContactEngine(robot, stack, q, 1e-3,
              options=RigidOptions(joint_damping=0.5)) for stack in contacts.stacks}
    for k in range(4):
        engine = stacks[contacts.at(k * 1e-3).size]
        state = engine.state
        command = controller.step(k * 1e-3, state.q, state.v, state.lam)
        after = engine.step(command.tau)
        told += [command.v_ref, command.s, command.u, command.tau, command.base_reaction,
                 after.q, after.v, after.lam]
np.save(sys.argv[1], np.concatenate(told))
"""


@pytest.mark.slow
def test_uncompiled_kernels_give_the_same_ticks(tmp_path):
    """Two controllers (least and bounded reactions) through a fade and a change of contacts."""
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
    assert np.abs((answers[0] - answers[1]) / scale).max() < 1e-7
