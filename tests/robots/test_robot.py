"""A Robot hands out what the model holds, read-only, and its copies change masses and no more."""

from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

from equipoise.errors import InputError, NameNotFoundError, NonFiniteError, RobotFileError
from equipoise.robots import Robot, Sole, get_robot
from equipoise.robots.base import require_joints_of_one_dof


@pytest.fixture(scope="module")
def robot() -> Robot:
    return get_robot("hrp2")


def inertia_matrix(model: pin.Model, q: np.ndarray) -> np.ndarray:
    upper = np.triu(pin.crba(model, model.createData(), q))
    return upper + np.triu(upper, 1).T


def test_names_follow_the_order_of_v(robot: Robot) -> None:
    assert len(robot.velocity_names) == robot.nv
    assert robot.velocity_names[6:] == robot.joint_names
    for i, name in enumerate(robot.joint_names):
        joint = robot.model.joints[robot.model.getJointId(name)]
        assert (joint.idx_v - 6, joint.idx_q - 7) == (i, i)
        assert robot.joint_index(name) == i


def test_frame_id_is_pinocchios_and_an_unknown_frame_is_named_kindly(robot: Robot) -> None:
    for name in ("left_sole", "BODY", "camera"):
        assert robot.model.frames[robot.frame_id(name)].name == name
    with pytest.raises(NameNotFoundError, match=r"LARM_LINK5, .* more\. Did you mean 'LARM_LINK5'"):
        robot.frame_id("larm_link5")  # capitals do not count; of many names the likest come first
    with pytest.raises(NameNotFoundError, match="left_sole"):
        robot.frame_id("left_sol")
    for ask in (robot.sole, robot.palm, robot.joint_index):
        with pytest.raises(NameNotFoundError):
            ask("nope")


@pytest.mark.parametrize("name", ["q_half_sitting", "q_min", "q_max", "v_max", "tau_max"])
def test_arrays_cannot_be_written(robot: Robot, name: str) -> None:
    with pytest.raises(ValueError, match="read-only"):
        getattr(robot, name)[0] = 1.0


def test_fields_cannot_be_replaced(robot: Robot) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        robot.name = "other"
    with pytest.raises(ValueError, match="read-only"):
        robot.soles[0].corners[0] = 1.0


def test_corners_go_anticlockwise_round_the_rectangle() -> None:
    sole = Sole("s", "s", -0.1, 0.13, -0.056, 0.075)
    x, y = sole.corners[:, 0], sole.corners[:, 1]
    signed_area = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    assert signed_area == pytest.approx(0.23 * 0.131)


def test_scaling_masses_scales_the_whole_inertia_matrix(robot: Robot) -> None:
    q = pin.integrate(
        robot.model, robot.q_half_sitting, np.random.default_rng(5).normal(size=robot.nv)
    )
    before = inertia_matrix(robot.model, q)
    heavy = robot.scaled(1.3)
    np.testing.assert_allclose(inertia_matrix(heavy.model, q), 1.3 * before, rtol=1e-12, atol=1e-12)
    assert heavy.mass == pytest.approx(1.3 * robot.mass)
    np.testing.assert_array_equal(inertia_matrix(robot.model, q), before)


def test_payload_adds_the_kinetic_energy_of_its_point(robot: Robot) -> None:
    rng = np.random.default_rng(4)
    q, v = robot.q_half_sitting, rng.normal(size=robot.nv)
    point = np.array([0.05, -0.02, 0.1])
    loaded = robot.with_payload("left_palm", 2.5, point)
    data = robot.model.createData()

    def place(t: float) -> np.ndarray:
        pin.framesForwardKinematics(robot.model, data, pin.integrate(robot.model, q, t * v))
        return data.oMf[robot.frame_id("left_palm")].act(point).copy()

    speed = (place(1e-6) - place(-1e-6)) / 2e-6
    added = 0.5 * v @ (inertia_matrix(loaded.model, q) - inertia_matrix(robot.model, q)) @ v
    assert added == pytest.approx(0.5 * 2.5 * speed @ speed, rel=1e-6)
    assert loaded.mass == pytest.approx(robot.mass + 2.5)
    assert robot.mass == pytest.approx(56.03715771)


def test_unit_inertias_on_every_moving_link(robot: Robot) -> None:
    plain = robot.with_unit_inertias()
    assert plain.mass == robot.na + 1
    for inertia in list(plain.model.inertias)[1:]:
        np.testing.assert_array_equal(inertia.inertia, np.eye(3))
        np.testing.assert_array_equal(inertia.lever, np.zeros(3))
    assert robot.mass == pytest.approx(56.03715771)
    np.testing.assert_array_equal(plain.tau_max, robot.tau_max)


def test_repr_is_one_short_line(robot: Robot) -> None:
    assert repr(robot).startswith("Robot('hrp2', 30 joints, 56.037 kg, ")
    assert "\n" not in repr(robot)


def test_bad_masses_are_refused(robot: Robot) -> None:
    for bad in (0.0, -1.0):
        with pytest.raises(InputError, match="positive"):
            robot.scaled(bad)
    with pytest.raises(NonFiniteError):
        robot.scaled(float("nan"))
    with pytest.raises(NonFiniteError):
        robot.with_payload("left_palm", float("inf"))
    with pytest.raises(InputError, match="negative"):
        robot.with_payload("left_palm", -1.0)
    with pytest.raises(InputError, match="three numbers"):
        robot.with_payload("left_palm", 1.0, (0.0, 0.0))
    with pytest.raises(NameNotFoundError, match="left_palm"):
        robot.with_payload("left_plam", 1.0)


def test_joints_of_other_kinds_are_refused() -> None:
    model = pin.Model()
    with pytest.raises(RobotFileError, match="no joint that moves"):
        require_joints_of_one_dof(model)
    base = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
    model.addJoint(base, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    with pytest.raises(RobotFileError, match=r"'ball'.*revolute"):
        require_joints_of_one_dof(model)
    wheel = pin.Model()
    base = wheel.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
    wheel.addJoint(base, pin.JointModelRUBX(), pin.SE3.Identity(), "wheel")
    with pytest.raises(RobotFileError, match="'wheel'"):
        require_joints_of_one_dof(wheel)
