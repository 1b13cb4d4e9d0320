"""A base that is fixed: what it is, and that it moves as a floating one on a bilateral mount."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from arms import arm_urdf, write_arm
from equipoise.contacts import Contact, ContactStack, SoleContact, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.control import ControlGains, SignFunction, advise_gains
from equipoise.errors import InputError, RobotFileError
from equipoise.physics import RigidContactEngine
from equipoise.robots import Robot, Sole, check_urdf, load_robot
from equipoise.tasks import ContactTask, FramePoseTask, JointLimitsTask, PostureTask
from equipoise.trajectories import Waypoint, WaypointTrajectory
from equipoise.wbc import ControlSettings, WholeBodyController

DT, TICKS = 1e-3, 1500


def test_a_fixed_base_has_no_entries(tmp_path: Path) -> None:
    arm = load_robot(write_arm(tmp_path, "fixed"))
    assert (arm.base.kind, arm.nq_base, arm.nv_base, arm.nq, arm.nv, arm.na) == (
        *("fixed", 0, 0),
        *(6, 6, 6),
    )
    assert arm.velocity_names == arm.joint_names == tuple(f"joint{k}" for k in range(1, 7))
    assert arm.base_position_names == () == arm.base_velocity_units
    assert arm.at(arm.q_half_sitting).placement("link0").isIdentity()
    assert arm.mass == pytest.approx(sum(3.0 - 0.4 * k for k in range(1, 7)))


def test_kinematics_of_a_fixed_base_are_pinocchios(tmp_path: Path, rng) -> None:
    arm = load_robot(write_arm(tmp_path, "fixed"))
    for _ in range(20):
        q, v = rng.uniform(-2, 2, arm.nq), rng.normal(size=arm.nv)
        kin, data = arm.at(q, v), arm.model.createData()
        pin.forwardKinematics(arm.model, data, q, v, np.zeros(arm.nv))
        pin.computeJointJacobians(arm.model, data, q)
        pin.updateFramePlacements(arm.model, data)
        frame, axes = arm.frame_id("hand"), pin.LOCAL_WORLD_ALIGNED
        J = pin.getFrameJacobian(arm.model, data, frame, axes)
        drift = pin.getFrameClassicalAcceleration(arm.model, data, frame, axes).vector
        assert np.abs(kin.jacobian("hand") - J).max() < 1e-12
        assert np.abs(kin.drift("hand") - drift).max() < 1e-11
        assert np.abs(kin.p_world_com - pin.centerOfMass(arm.model, data, q)).max() < 1e-12
        assert np.abs(kin.J_com - pin.jacobianCenterOfMass(arm.model, data, q)).max() < 1e-12


def test_a_first_link_called_world_is_the_world(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    fixed = '<link name="world"/><joint name="mount" type="{}"><parent link="world"/>'
    fixed += '<child link="link0"/><origin xyz="0 0 0.3"/></joint>'
    for kind, base in (("fixed", "fixed"), ("floating", "floating")):
        path.write_text(arm_urdf().replace("</robot>", fixed.format(kind) + "</robot>"))
        robot = load_robot(path)
        assert robot.base.kind == base
        assert not [f for f in check_urdf(path) if f.severity == "error"]
    assert "world" not in robot.frame_names
    assert load_robot(path, base="fixed").base.kind == "fixed"


def test_a_first_link_that_is_fixed_needs_no_mass(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    text = arm_urdf()
    path.write_text('<robot name="arm"><link name="link0"/>' + text[text.index("</link>") + 7 :])
    assert load_robot(path, base="fixed").nv == 6
    with pytest.raises(RobotFileError, match="a moving link without mass"):
        load_robot(path)


def test_a_fixed_base_stands_where_it_is_told(tmp_path: Path, rng) -> None:
    """All that hangs on it moves with it, and gravity turns the other way round."""
    path = write_arm(tmp_path, "fixed")
    plain = load_robot(path)
    yaml = path.with_suffix(".yaml")
    yaml.write_text(yaml.read_text() + "base_at: {xyz: [0.3, -0.2, 0.9], rpy: [0.4, -0.3, 1.1]}\n")
    placed = load_robot(path)
    T = pin.SE3(pin.rpy.rpyToMatrix(0.4, -0.3, 1.1), np.array([0.3, -0.2, 0.9]))
    assert placed.at(placed.q_half_sitting).placement("link0").isApprox(T)
    turned = plain.model.copy()
    turned.gravity.linear = T.rotation.T @ plain.model.gravity.linear
    for _ in range(5):
        q, v, a = rng.uniform(-2, 2, plain.nq), rng.normal(size=plain.nv), rng.normal(size=plain.nv)
        for frame in ("link0", "link3", "hand"):
            there = placed.at(q).placement(frame)
            assert there.isApprox(T * plain.at(q).placement(frame), 1e-12)
        tau = pin.rnea(placed.model, placed.model.createData(), q, v, a)
        assert tau == pytest.approx(pin.rnea(turned, turned.createData(), q, v, a), abs=1e-10)
    with pytest.raises(RobotFileError, match="this one floats"):
        load_robot(path, base="floating")


def test_a_planar_base_is_three_joints_that_carry_it(tmp_path: Path, rng) -> None:
    """Inertia and bias are those of the floating robot, restricted to the plane."""
    path = write_arm(tmp_path, "planar")
    yaml = path.with_suffix(".yaml")
    yaml.write_text(yaml.read_text() + "wheels: {speed: 0.7, force: 300.0}\n")
    rolling, floating = load_robot(path), load_robot(path, base="floating")
    assert rolling.joint_names[:4] == ("base_x", "base_y", "base_yaw", "joint1")
    assert (rolling.nv_base, rolling.na, rolling.soles) == (0, 9, ())
    assert rolling.v_max[:3] == pytest.approx([0.7, 0.7, 1.5])
    assert rolling.tau_max[:3] == pytest.approx([300.0, 300.0, 150.0])
    assert len(rolling.collision_model.geometryObjects) == len(
        floating.collision_model.geometryObjects
    )
    for _ in range(5):
        q, v = rng.uniform(-2, 2, rolling.nq), rng.normal(size=rolling.nv)
        T = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, q[2]), np.array([q[0], q[1], 0.0]))
        full = np.concatenate((pin.SE3ToXYZQUAT(T), q[3:]))
        S = np.zeros((12, 9))  # base velocities in base axes from those of the three joints
        S[:3, :2], S[5, 2], S[6:, 3:] = T.rotation.T[:, :2], 1.0, np.eye(6)
        M = np.array(pin.crba(floating.model, floating.model.createData(), full))
        M = np.triu(M) + np.triu(M, 1).T
        mine = np.array(pin.crba(rolling.model, rolling.model.createData(), q))
        assert np.triu(mine) == pytest.approx(np.triu(S.T @ M @ S), abs=1e-10)
        here, there = rolling.at(q, v), floating.at(full, S @ v)
        assert here.placement("hand").isApprox(there.placement("hand"))
        assert here.jacobian("hand") @ v == pytest.approx(there.jacobian("hand") @ S @ v)
    assert [f for f in check_urdf(yaml) if f.severity == "error"] == []


def test_a_robot_on_wheels_drives_to_what_it_cannot_reach(tmp_path: Path) -> None:
    robot = load_robot(write_arm(tmp_path, "planar"))
    T = robot.at(robot.q_half_sitting).placement("hand")
    far = pin.SE3(T.rotation, T.translation + np.array([1.5, 0.8, 0.1]))
    way = WaypointTrajectory([Waypoint(0.0, T), Waypoint(3.0, far)])
    hand = FramePoseTask("hand", "hand", way)
    controller = WholeBodyController.fixed(robot, tasks=[hand])
    engine = RigidContactEngine(robot, controller.contacts, robot.q_half_sitting, DT)
    controller.take_over(engine.stand())
    state, share = engine.state, 0.0
    for k in range(3500):
        command = controller.step(k * DT, state.q, state.v, state.lam)
        state = engine.step(command.tau)
        share = max(share, float((np.abs(command.tau) / robot.tau_max).max()))
    assert np.abs(hand.error(robot.at(state.q), 3.5)).max() < 1e-4
    assert np.hypot(*state.q[:2]) > 0.5
    assert share < 1.0


def test_other_bases_are_refused(tmp_path: Path) -> None:
    path = write_arm(tmp_path, "fixed")
    with pytest.raises(InputError, match="no base of this kind"):
        load_robot(path, base="flying")
    path.with_suffix(".yaml").write_text("base: flying\n")
    with pytest.raises(RobotFileError, match="line 1, base"):
        load_robot(path)


def test_a_fixed_base_without_joints_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "stone.urdf"
    path.write_text('<robot name="stone"><link name="world"/></robot>')
    with pytest.raises(RobotFileError, match="no joint that moves"):
        load_robot(path)


# -- two answers: fixed to the world, and floating on a mount that holds in all directions --------


def mount(arm: Robot) -> SoleContact:
    base = Sole("mount", "link0", -0.1, 0.1, -0.1, 0.1)
    return SoleContact.standing(base, arm.at(arm.q_half_sitting))


def in_closed_loop(arm: Robot, supports: list[Contact], *, press: bool) -> list[np.ndarray]:
    """Return joints, their reference, torques and the force of each tick of a reach."""
    start = arm.at(arm.q_half_sitting)
    T = start.placement("hand")
    contacts, first = list(supports), [arm.q_half_sitting, np.zeros(arm.nv)]
    turn = pin.exp3(np.array([0.0, 0.2, 0.1]))
    goal = pin.SE3(T.rotation @ turn, T.translation + np.array([-0.1, 0.15, 0.1]))
    if press:
        plane = SurfaceContact(
            name="table", regulated=("fn",), frame="hand", surface=Plane(), T_world_surface=pin.SE3(
                np.eye(3), T.translation
            ),
        )  # fmt: skip
        contacts.append(plane)
        goal = pin.SE3(T.rotation, T.translation + np.array([-0.1, 0.15, 0.0]))
    stack = ContactStack(contacts)
    path = WaypointTrajectory([Waypoint(0.0, T), Waypoint(1.0, goal)])
    levels = [
        [ContactTask("contacts", stack)],
        [JointLimitsTask("limits", arm)],
        [FramePoseTask("hand", "hand", path)],
        [PostureTask("posture", arm, arm.q_half_sitting[arm.nq_base :])],
    ]
    K_d = advise_gains(arm, stack, first[0], DT, alpha=10.0, kappa=100.0).K_d
    gains = ControlGains(K_d=K_d, alpha=10.0, k_ip=0.5, sgn_p=SignFunction("saturation", 0.01))
    controller = WholeBodyController(
        arm, levels, stack, ControlSettings(gains, DT), first[0],
        wanted_forces={"table": [lambda t: 5.0 + 10.0 * min(t, 1.0)]} if press else None,
    )  # fmt: skip
    engine = RigidContactEngine(arm, stack, first[0], DT)
    state, seen = engine.state, []
    for k in range(TICKS):
        command = controller.step(k * DT, state.q, state.v, state.lam)
        force = state.lam[-1:] if press else np.zeros(1)
        joints = slice(arm.nq_base, None), slice(arm.nv_base, None)
        q, q_ref, v = state.q[joints[0]], command.q_ref[joints[0]], state.v[joints[1]]
        seen.append(np.concatenate((q, q_ref, v, force, command.tau)))
        state = engine.step(command.tau)
    assert command.mode.name == "RUN"
    error = goal.translation - arm.at(command.q_ref).placement("hand").translation
    assert np.abs(error).max() < 1e-4
    return seen


@pytest.mark.parametrize("press", [False, True], ids=["reach", "press"])
def test_fixed_is_floating_on_a_mount(tmp_path: Path, press: bool) -> None:
    """The same joints, references, speeds, force and torque, tick by tick, to 1e-6."""
    fixed = load_robot(write_arm(tmp_path, "fixed"))
    floating = load_robot(write_arm(tmp_path, "floating"))
    one = np.array(in_closed_loop(fixed, [], press=press))
    other = np.array(in_closed_loop(floating, [mount(floating)], press=press))
    assert np.abs(one - other).max() < 1e-6
    assert np.ptp(one[:, 0]) > 0.05  # it moved
