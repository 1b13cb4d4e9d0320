"""A frame or an id that the robot does not have is refused wherever one can be given."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import (
    ContactStack,
    GraspContact,
    PointContact,
    SoleContact,
    SurfaceContact,
)
from equipoise.contacts.surfaces import Plane
from equipoise.errors import InputError
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.physics import RigidContactEngine
from equipoise.robots import Sole
from equipoise.spatial import pose
from equipoise.tasks import ContactTask, FramePoseTask, GazeTask
from equipoise.trajectories import FixedPose
from helpers import kinematics

HERE = pose((0.0, 0.0, 0.0))


def moved(robot, task):
    """Return what a motion with one task does in one step."""
    solver = make_solver("active_set")
    return MotionGenerator(robot, [[task]], solver, 0.005, robot.q_half_sitting).step(0.0)


def stacked(robot, contact):
    """Return the rows of a contact alone, in a motion and in the rigid engine."""
    stack = ContactStack([contact])
    answers = []
    for ask in (
        lambda: stack.at(kinematics(robot, robot.q_half_sitting)),
        lambda: moved(robot, ContactTask("c", stack)),
        lambda: RigidContactEngine(robot, stack, robot.q_half_sitting, 0.001).step(
            np.zeros(robot.na)
        ),
    ):
        with pytest.raises(InputError) as caught:
            ask()
        answers.append(caught.value)
    raise answers[0]


BOX = (Shape("box", (0.1, 0.1, 0.1), HERE),)
TAKERS = {
    "placement": lambda r, f: kinematics(r, r.q_half_sitting).placement(f),
    "jacobian": lambda r, f: kinematics(r, r.q_half_sitting).jacobian(f),
    "twist": lambda r, f: kinematics(r, r.q_half_sitting).twist(f),
    "drift": lambda r, f: kinematics(r, r.q_half_sitting).drift(f),
    "with_frames": lambda r, f: kinematics(r, r.q_half_sitting).with_frames([f]),
    "pose task": lambda r, f: moved(r, FramePoseTask("hand", f, FixedPose(HERE))),
    "pose rows": lambda r, f: FramePoseTask("hand", f, FixedPose(HERE)).rows(
        kinematics(r, r.q_half_sitting), 0.0
    ),
    "gaze task": lambda r, f: moved(r, GazeTask("look", f, FixedPose(HERE))),
    "gaze error": lambda r, f: GazeTask("look", f, FixedPose(HERE)).error(
        kinematics(r, r.q_half_sitting), 0.0
    ),
    "body": lambda r, f: Scene(r, [Body("b", BOX, HERE, f)]),
    "payload": lambda r, f: r.with_payload(f, 1.0),
    "point": lambda r, f: stacked(r, PointContact(name="p", frame=f, p_world=np.zeros(3))),
    "grasp": lambda r, f: stacked(
        r, GraspContact(name="g", frame_a="left_palm", frame_b=f, T_a_b=HERE)
    ),
    "surface": lambda r, f: stacked(r, SurfaceContact(name="s", frame=f, surface=Plane())),
    "sole": lambda r, f: stacked(
        r,
        SoleContact(name="s", sole=Sole("s", f, -0.1, 0.1, -0.1, 0.1), T_world_anchor=HERE),
    ),
    "holding": lambda r, f: GraspContact.holding("g", kinematics(r, r.q_half_sitting), f, f),
}


@pytest.mark.parametrize("frame", ["right_plam", "", 77, 99999, -1, 10**12, 1.0, True, None])
@pytest.mark.parametrize("take", TAKERS.values(), ids=TAKERS)
def test_a_frame_that_is_none_is_refused(hrp2, take, frame):
    assert hrp2.model.nframes <= 77
    if frame is None and take is TAKERS["body"]:
        return  # a body fixed in the world
    with pytest.raises(InputError) as caught:
        take(hrp2, frame)
    message = str(caught.value)
    if isinstance(frame, str):
        assert "frame" in message
        assert "right_palm" in message or "Known" in message


def test_what_pinocchio_answers_for_a_name_it_does_not_know_is_refused(hrp2):
    unknown = hrp2.model.getFrameId("right_plam")
    with pytest.raises(InputError, match="frame_names"):
        kinematics(hrp2, hrp2.q_half_sitting).placement(unknown)


@pytest.mark.parametrize("joint", [-1, 10**6])
def test_a_joint_that_is_none_is_refused(hrp2, joint):
    with pytest.raises(InputError, match="joints 0 to"):
        kinematics(hrp2, hrp2.q_half_sitting).joint_placement(joint)


def test_ids_and_names_of_frames_say_the_same(hrp2):
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    for frame, name in enumerate(hrp2.frame_names):
        if hrp2.frame_id(name) == frame:
            assert kin.placement(frame) == kin.placement(name)
            assert kin.placement(np.int64(frame)) == kin.placement(name)
