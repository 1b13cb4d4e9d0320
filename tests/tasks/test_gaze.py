"""Gaze: the angle shrinks at its rate toward targets anywhere, behind too, and a side is kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from equipoise.contacts import ContactStack, SoleContact
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.robots import Robot, load_robot
from equipoise.spatial import pose
from equipoise.tasks import ContactTask, GazeTask, JointLimitsTask
from equipoise.trajectories import FixedPose, Waypoint, WaypointTrajectory
from helpers import kinematics, random_state

STEP = 1e-6
INERTIAL = (
    '<inertial><mass value="1"/>'
    '<inertia ixx=".01" ixy="0" ixz="0" iyy=".01" iyz="0" izz=".01"/></inertial>'
)


def head(folder: Path, pan: float = 3.1, tilt: float = 1.5) -> Robot:
    """Return a camera that pans and tilts [rad] about its own place on a base that stands."""

    def joint(name: str, parent: str, child: str, axis: str, most: float) -> str:
        return (
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            f'<axis xyz="{axis}"/><limit lower="{-most}" upper="{most}" velocity="5" effort="50"/>'
            "</joint>"
        )

    links = "".join(f'<link name="{name}">{INERTIAL}</link>' for name in ("foot", "head", "cam"))
    joints = joint("pan", "foot", "head", "0 0 1", pan) + joint(
        "tilt", "head", "cam", "0 1 0", tilt
    )
    (folder / "head.urdf").write_text(f'<robot name="head">{links}{joints}</robot>')
    sole = "{name: s, frame: foot, x_min: -0.1, x_max: 0.1, y_min: -0.1, y_max: 0.1}"
    (folder / "head.yaml").write_text(f"camera: cam\nsoles:\n  - {sole}\n")
    return load_robot(folder / "head.urdf")


def target_at(robot: Robot, bearing: float, elevation: float) -> np.ndarray:
    """Return the place of a target 2 m away in a direction [deg] from the camera at rest."""
    b, e = np.radians((bearing, elevation))
    away = np.array([np.cos(b) * np.cos(e), np.sin(b) * np.cos(e), np.sin(e)])
    return kinematics(robot, robot.q_half_sitting).placement("cam").translation + 2.0 * away


def looked(robot: Robot, target: np.ndarray, seconds: float = 6.0) -> tuple[np.ndarray, np.ndarray]:
    """Return over time the angle to a target and the pan angle [rad]."""
    kin = kinematics(robot, robot.q_half_sitting)
    task = GazeTask("look", "cam", FixedPose(pose(target)))
    sole = SoleContact.standing(robot.soles[0], kin)
    levels = [
        [ContactTask("c", ContactStack([sole]))],
        [JointLimitsTask("l", robot)],
        [task],
    ]
    solver = make_solver("active_set")
    motion = MotionGenerator(robot, levels, solver, 0.005, robot.q_half_sitting)
    angles, pans = [], []
    for k in range(round(seconds / 0.005)):
        step = motion.step(0.005 * k)
        angles.append(float(np.linalg.norm(task.error(step.kin, step.t))))
        pans.append(step.q_ref[7])
    return np.array(angles), np.array(pans)


@pytest.mark.parametrize("elevation", [-60.0, -10.0, 0.0, 10.0, 60.0, 80.0])
@pytest.mark.parametrize("bearing", [0.0, 60.0, 89.0, 100.0, -100.0, 150.0, -170.0, 177.0])
def test_a_head_turns_to_targets_anywhere(tmp_path, bearing, elevation):
    robot = head(tmp_path)
    angles, pans = looked(robot, target_at(robot, bearing, elevation))
    assert np.degrees(angles[-1]) < 0.1
    assert np.degrees(pans[-1]) == pytest.approx(bearing, abs=0.2)


@pytest.mark.parametrize("elevation", [0.0, 1e-7, 1e-3, 30.0, -30.0, 70.0])
def test_straight_behind_a_side_is_chosen_and_kept(tmp_path, elevation):
    """The stop is 3 deg before straight behind: the head gets there on one way, the left one."""
    robot = head(tmp_path)
    angles, pans = looked(robot, target_at(robot, 180.0, elevation))
    assert pans.min() >= 0.0
    assert pans[-1] == pytest.approx(3.09, abs=1e-6)
    assert np.degrees(angles[-1]) <= np.degrees(np.pi - 3.09) + 1e-6


def test_a_head_that_can_hardly_nod_turns_round_all_the_same(tmp_path):
    robot = head(tmp_path, tilt=0.3)
    angles, _ = looked(robot, target_at(robot, 170.0, 15.0))
    assert np.degrees(angles[-1]) < 0.1


@pytest.mark.parametrize("bearing", [30.0, 120.0, 170.0])
def test_the_angle_and_not_its_sine_shrinks_at_the_rate(tmp_path, bearing):
    """With joints fast enough, the angle is `exp(-rate t)` of what it was, at any size."""
    robot = head(tmp_path)
    angles, _ = looked(robot, target_at(robot, bearing, 0.0), seconds=2.0)
    begun = int(np.argmax(angles < 0.8))  # below that, 5 /s asks for less than the limit of 5 rad/s
    later = begun + 100
    assert angles[later] / angles[begun] == pytest.approx((1.0 - 5.0 * 0.005) ** 100, rel=0.02)


def test_gaze_rows_are_the_rate_of_the_direction(hrp2, rng):
    """Two unit vectors across the ray, found again here, say what `A v` and the bounds must be."""
    first, last = pose((0.4, 0.1, 0.8)), pose((-0.6, -0.9, 0.9))
    way = WaypointTrajectory([Waypoint(0.0, first), Waypoint(2.0, last)])
    task = GazeTask("look", "camera", way, rate=3.0)
    for t in (0.2, 1.0, 1.9):
        q, v = random_state(hrp2, rng)

        def direction(kin, t):
            ray = kin.placement("camera").actInv(way.at(t).T_world_target.translation)
            return ray / np.linalg.norm(ray)

        def at(h, q=q, v=v, t=t):
            return direction(kinematics(hrp2, pin.integrate(hrp2.model, q, v * h)), t + h)

        kin = kinematics(hrp2, q)
        rows, ray = task.rows(kin, t), direction(kin, t)
        carry = pin.Quaternion.FromTwoVectors(np.array([1.0, 0.0, 0.0]), ray).toRotationMatrix()
        rate = carry[:, 1:].T @ (at(STEP) - at(-STEP)) / (2 * STEP)
        feedforward_and_error = rows.lower + 3.0 * task.error(kin, t)
        assert np.allclose(rows.A @ v - feedforward_and_error, rate, atol=1e-6)


@settings(max_examples=200, deadline=None)
@given(st.floats(-180.0, 180.0), st.floats(-90.0, 90.0))
def test_what_is_asked_always_leads_nearer(hrp2, bearing, elevation):
    """The wanted speed of the ray never grows the angle, and its size is the rate times it."""
    q = hrp2.q_half_sitting
    T = kinematics(hrp2, q).placement("camera")
    b, e = np.radians((bearing, elevation))
    ray = np.array([np.cos(b) * np.cos(e), np.sin(b) * np.cos(e), np.sin(e)])
    task = GazeTask("look", "camera", FixedPose(pose(T.act(2.0 * ray))))
    error = task.error(kinematics(hrp2, q), 0.0)
    angle = np.arctan2(np.hypot(ray[1], ray[2]), ray[0])
    assert np.linalg.norm(error) == pytest.approx(angle, abs=1e-9)
    if ray[0] > -1.0 + 1e-6:
        carry = pin.Quaternion.FromTwoVectors(np.array([1.0, 0.0, 0.0]), ray).toRotationMatrix()
        assert (carry[:, 1:] @ -error)[0] > -1e-9  # the ray gains along the axis


def test_gaze_behind_still_has_an_error(hrp2):
    q = hrp2.q_half_sitting
    T = kinematics(hrp2, q).placement("camera")
    task = GazeTask("look", "camera", FixedPose(T * pose((-1.0, 0.0, 0.0))))
    assert np.linalg.norm(task.error(kinematics(hrp2, q), 0.0)) == pytest.approx(np.pi)


def test_a_target_in_the_camera_itself_asks_for_nothing(hrp2):
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    rows = GazeTask("look", "camera", FixedPose(kin.placement("camera"))).rows(kin, 0.0)
    assert np.isfinite(rows.A).all()
    assert np.array_equal(rows.lower, np.zeros(2))
