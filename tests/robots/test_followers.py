"""Joints that follow others: the reduced robot against the whole one, folded by a G of our own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from equipoise import RigidContactEngine, WholeBodyController
from equipoise.contacts import ContactStack, GraspContact, PointContact, SoleContact
from equipoise.errors import InputError, RobotFileError
from equipoise.physics import RigidOptions
from equipoise.robots import Robot, Sole, check_urdf, load_robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.robots.files.finding import WARNING
from equipoise.tasks import FrameAxesTask, FramePoseTask, RelativeFrameTask
from equipoise.trajectories import FixedPose

LINK = """<link name="{name}"><inertial><origin xyz="0.05 0.02 0.1"/><mass value="{mass}"/>
<inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0.001" ixz="0.002" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="0.1 0.05 0.2" rpy="0.1 0.2 0.3"/><axis xyz="{axis}"/>
<limit lower="-1" upper="{upper}" effort="300" velocity="{speed}"/>
<dynamics damping="0.3" friction="0.1"/>{mimic}</joint>"""
# In the order that they get: a finger of the left hand stands before its leader, and two joints
# of one chain follow one that is in it, one of them over a third.
JOINTS = (
    ("turn", "base", "lower", "0 0 1", "revolute", None),
    ("bend", "lower", "middle", "0 1 0", "revolute", None),
    ("again", "middle", "upper", "0.8 0 0.6", "revolute", ("turn", -0.5, 0.1)),
    ("left", "upper", "left_finger", "0 1 0", "prismatic", ("right", 2.0, 0.05)),
    ("right", "upper", "right_finger", "0 0 1", "prismatic", None),
    ("tip", "right_finger", "right_tip", "0 0.6 0.8", "revolute", ("again", 2.0, -0.3)),
)
OWN = ("turn", "bend", "right")  # the coordinates that are left
G = np.array([[1, 0, 0], [0, 1, 0], [-0.5, 0, 0], [0, 0, 2.0], [0, 0, 1], [-1.0, 0, 0]])
OFFSET = np.array([0, 0, 0.1, 0.05, 0, 2.0 * 0.1 - 0.3])
FRAMES = ("middle", "upper", "left_finger", "right_finger", "right_tip")


def text(*, coupled: bool) -> str:
    links = [LINK.format(name=n, mass=4.0) for n in ("base", *(joint[2] for joint in JOINTS))]
    joints = []
    for name, parent, child, axis, kind, law in JOINTS:
        mimic = '<mimic joint="{}" multiplier="{}" offset="{}"/>'.format(*law) if law else ""
        joints.append(
            JOINT.format(
                name=name, parent=parent, child=child, axis=axis, kind=kind,
                mimic=mimic if coupled else "", upper=0.3 if name == "left" else 1.2,
                speed=1.5 if name == "left" else 2.0,
            )
        )  # fmt: skip
    return '<robot name="coupled">' + "\n".join([*links, *joints]) + "</robot>"


def write(folder: Path, urdf: str, yaml: str = "base: fixed\n", name: str = "robot") -> Path:
    path = folder / f"{name}.urdf"
    path.write_text(urdf, encoding="utf-8")
    path.with_suffix(".yaml").write_text(yaml, encoding="utf-8")
    return path


class Pair:
    """The robot with its couplings, and the one without; what belongs together in them."""

    def __init__(self, folder: Path, base: str) -> None:
        yaml = f"base: {base}\n"
        self.robot = load_robot(write(folder, text(coupled=True), yaml))
        self.whole = load_robot(write(folder, text(coupled=False), yaml, "whole"))
        self.base = self.robot.nv_base
        own, all_ = self.robot.joint_names, self.whole.joint_names
        rows = [[joint[0] for joint in JOINTS].index(name) for name in all_]
        columns = [OWN.index(name) for name in own]
        self.offset = OFFSET[rows]
        self.joints = G[np.ix_(rows, columns)]
        self.G = np.zeros((self.whole.nv, self.robot.nv))
        self.G[: self.base, : self.base] = np.eye(self.base)
        self.G[self.base :, self.base :] = self.joints

    def spread(self, q: np.ndarray) -> np.ndarray:
        n = self.robot.nq_base
        return np.concatenate((q[:n], self.joints @ q[n:] + self.offset))

    def state(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        q = pin.integrate(
            self.robot.model, self.robot.q_half_sitting, 0.5 * rng.normal(size=self.robot.nv)
        )
        return q, rng.normal(size=self.robot.nv)


@pytest.fixture(scope="module", params=["fixed", "floating"])
def pair(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Pair:
    return Pair(tmp_path_factory.mktemp(request.param), request.param)


def test_only_leaders_have_coordinates(pair: Pair) -> None:
    assert set(pair.robot.joint_names) == set(OWN)
    assert pair.robot.nv == pair.base + 3
    assert set(pair.robot.followers) == {"again", "left", "tip"}
    assert pair.robot.followers["tip"] == ("turn", pytest.approx(-1.0), pytest.approx(-0.1))
    tip = pair.robot.joints_between("right_tip")
    assert {pair.robot.joint_names[k] for k in tip} == set(OWN)


def test_kinematics_are_those_of_the_whole_robot(pair: Pair, rng: np.random.Generator) -> None:
    for _ in range(5):
        q, v = pair.state(rng)
        kin, there = pair.robot.at(q, v), pair.whole.at(pair.spread(q), pair.G @ v)
        for frame in FRAMES:
            assert kin.placement(frame).isApprox(there.placement(frame), 1e-12)
            assert np.abs(kin.jacobian(frame) - there.jacobian(frame) @ pair.G).max() < 1e-13
            assert np.abs(kin.twist(frame) - there.twist(frame)).max() < 1e-12
            assert np.abs(kin.drift(frame) - there.drift(frame)).max() < 1e-11
        assert np.abs(kin.p_world_com - there.p_world_com).max() < 1e-13
        assert np.abs(kin.J_com - there.J_com @ pair.G).max() < 1e-13


def test_jacobians_are_rates_through_the_coupling(pair: Pair, rng: np.random.Generator) -> None:
    q, v = pair.state(rng)
    h, kin = 1e-6, pair.robot.at(q, v)
    after, before = (pair.robot.at(pin.integrate(pair.robot.model, q, s * v)) for s in (h, -h))
    for frame in FRAMES:
        one, other = after.placement(frame), before.placement(frame)
        rate = (one.translation - other.translation) / (2 * h)
        turn = pin.log3(one.rotation @ other.rotation.T) / (2 * h)
        assert np.abs(kin.jacobian(frame) @ v - np.concatenate((rate, turn))).max() < 1e-8


def test_power_and_dynamics_are_folded(pair: Pair, rng: np.random.Generator) -> None:
    """`M_r = G^T M G`, `h_r = G^T h`, and `tau_r . v_r = tau . v`, whatever the whole's torques."""
    mine, theirs = JointDynamics(pair.robot.model), JointDynamics(pair.whole.model)
    for _ in range(5):
        (q, v), a = pair.state(rng), rng.normal(size=pair.robot.nv)
        there, moving = pair.spread(q), pair.G @ v
        M, h = theirs.inertia(there), theirs.bias(there, moving)
        assert np.abs(mine.inertia(q) - pair.G.T @ M @ pair.G).max() < 1e-11
        assert np.abs(mine.bias(q, v) - pair.G.T @ h).max() < 1e-10
        assert np.abs(mine.coriolis(q, v) @ v + mine.gravity(q) - mine.bias(q, v)).max() < 1e-10
        tau, tau_r = M @ (pair.G @ a) + h, mine.inertia(q) @ a + mine.bias(q, v)
        assert tau_r @ v == pytest.approx(tau @ moving, rel=1e-11)


def contacts_of(robot: Robot, q: np.ndarray) -> list[object]:
    kin = robot.at(q)
    sole = Sole("s", "right_tip", -0.1, 0.1, -0.1, 0.1)
    return [
        SoleContact(name="sole", sole=sole, T_world_anchor=kin.placement("right_tip")),
        PointContact(
            name="point", frame="left_finger", p_world=kin.placement("left_finger").translation,
            offset=(0.1, 0.2, 0.3),
        ),
        GraspContact(
            name="grasp", frame_a="left_finger", frame_b="right_tip",
            T_a_b=kin.placement("left_finger").inverse() * kin.placement("right_tip"),
        ),
    ]  # fmt: skip


def test_rows_of_contacts_are_folded(pair: Pair, rng: np.random.Generator) -> None:
    q, v = pair.state(rng)
    near = pin.integrate(pair.robot.model, q, 0.05 * v)
    mine = ContactStack(contacts_of(pair.robot, near))
    theirs = ContactStack(contacts_of(pair.whole, pair.spread(near)))
    kin, there = pair.robot.at(q, v), pair.whole.at(pair.spread(q), pair.G @ v)
    assert np.abs(mine.jacobian(kin) - theirs.jacobian(there) @ pair.G).max() < 1e-12
    assert np.abs(mine.residual(kin) - theirs.residual(there)).max() < 1e-12
    assert np.abs(mine.drift(kin) - theirs.drift(there)).max() < 1e-11


def test_rows_of_tasks_are_folded(pair: Pair, rng: np.random.Generator) -> None:
    q, v = pair.state(rng)
    T = FixedPose(pin.SE3.Random())
    kin, there = pair.robot.at(q, v), pair.whole.at(pair.spread(q), pair.G @ v)
    for task in (
        FramePoseTask("pose", "right_tip", T),
        FrameAxesTask("axes", "left_finger", T, axes=("x", "rz"), offset=(0.1, 0.0, 0.2)),
        RelativeFrameTask("both", "right_tip", "left_finger", T),
    ):
        mine, theirs = task.rows(kin, 0.0), task.rows(there, 0.0)
        assert np.abs(mine.A - theirs.A @ pair.G).max() < 1e-12
        assert np.abs(mine.lower - theirs.lower).max() < 1e-12


def test_a_leader_moves_within_the_limits_of_its_followers(pair: Pair) -> None:
    robot, at = pair.robot, pair.robot.joint_index
    right, turn = at("right"), at("turn")
    assert robot.q_min[right] == pytest.approx((-1.0 - 0.05) / 2.0)
    assert robot.q_max[right] == pytest.approx((0.3 - 0.05) / 2.0)
    assert robot.v_max[right] == pytest.approx(1.5 / 2.0)
    assert robot.q_max[turn] == pytest.approx(0.9)  # the tip's lower end: -q - 0.1 >= -1
    assert robot.q_min[turn] == pytest.approx(-1.0)
    assert robot.tau_max == pytest.approx([300.0] * 3)  # a follower has no motor
    joints = robot.nv_base + np.array([turn, right])
    assert robot.model.damping[joints] == pytest.approx([0.3 * (1 + 0.25 + 1.0), 0.3 * (1 + 4)])
    friction = robot.model.upperDryFrictionLimit[joints]
    assert friction == pytest.approx([0.1 * (1 + 0.5 + 1.0), 0.1 * (1 + 2)])


def told(path: Path) -> str:
    return " ".join(str(f) for f in check_urdf(path) if f.severity == WARNING)


def coupled_by(*laws: tuple[str, str, float]) -> str:
    found = text(coupled=False)
    for name, leader, ratio in laws:
        at = found.index("</joint>", found.index(f'<joint name="{name}"'))
        found = f'{found[:at]}<mimic joint="{leader}" multiplier="{ratio}"/>{found[at:]}'
    return found


def test_joints_that_follow_each_other_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RobotFileError, match=r"in a circle.*'left', 'right'"):
        load_robot(write(tmp_path, coupled_by(("left", "right", 1.0), ("right", "left", 1.0))))
    with pytest.raises(RobotFileError, match="'bend' follows 'tip', which hangs on it"):
        load_robot(write(tmp_path, coupled_by(("bend", "tip", 1.0))))


def test_who_follows_what_does_not_move_is_locked(tmp_path: Path) -> None:
    path = write(tmp_path, text(coupled=True), "base: fixed\nlocked: {turn: 0.4}\n")
    robot = load_robot(path)
    assert robot.joint_names == ("bend", "right")
    whole = load_robot(write(tmp_path, text(coupled=False), name="whole"))
    q = np.array([0.4, 0.2, 0.1 - 0.2, 2 * 0.1 + 0.05, 0.1, -0.4 - 0.1])
    there = whole.at(q).placement("right_tip")
    assert robot.at(np.array([0.2, 0.1])).placement("right_tip").isApprox(there, 1e-12)
    assert "follows" not in told(path)
    lost = write(tmp_path, coupled_by(("left", "none", 1.0)))
    assert load_robot(lost).na == 5
    assert "'left'" in told(lost)
    assert "'none'" in told(lost)


def test_limits_that_leave_no_room_are_told(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        coupled_by(("left", "right", -1e-3)).replace(
            'lower="-1" upper="0.3"', 'lower="0.1" upper="0.3"'
        ),
    )
    robot = load_robot(path)
    assert "no room" in told(path)
    assert robot.q_min[robot.joint_index("right")] == -1.0


def ends_of(robot: Robot, engine: object, tau: np.ndarray, ticks: int) -> list[np.ndarray]:
    return [engine.step(tau).q for _ in range(ticks)]


def test_both_engines_move_it_the_same(tmp_path: Path) -> None:
    """MuJoCo holds the couplings by springs of its solver, ours by having no other coordinates."""
    pytest.importorskip("mujoco")
    from equipoise.physics.mujoco import MujocoEngine, MujocoOptions
    from equipoise.physics.mujoco.names import of_joint

    robot = Pair(tmp_path, "fixed").robot
    tau, none = JointDynamics(robot.model).gravity(robot.q_half_sitting), ContactStack([])
    tau = tau + np.array([30.0, -40.0, 80.0])
    gaps, laws = [], []
    for substeps in (2, 8):
        rigid = RigidContactEngine(
            robot, none, robot.q_half_sitting, 1e-3, options=RigidOptions(substeps=substeps)
        )
        lossless = MujocoOptions(
            substeps=substeps, joint_friction=0.0, joint_damping=0.0, armature=0.0
        )
        theirs = MujocoEngine(robot, none, robot.q_half_sitting, 1e-3, options=lossless)
        one, other = (ends_of(robot, engine, tau, 100)[-1] for engine in (rigid, theirs))
        assert np.abs(one - robot.q_half_sitting).max() > 0.02
        gaps.append(np.abs(one - other).max() / np.abs(one - robot.q_half_sitting).max())
        simulated, found = theirs.simulated, []
        for name, (leader, ratio, offset) in robot.followers.items():
            q, lead = (simulated.joint(of_joint(n)).qpos[0] for n in (name, leader))
            found.append(abs(q - ratio * lead - offset))
        laws.append(max(found))
    assert laws[1] < 0.2 * laws[0] < 1e-4  # [rad, m]: as stiff as the steps are short
    assert gaps[1] < 0.3 * gaps[0]
    assert gaps[1] < 1e-3


@pytest.mark.parametrize("engine", ["rigid", "mujoco"])
def test_a_controller_moves_what_is_coupled(tmp_path: Path, engine: str) -> None:
    """The tip, which one motor turns over three joints, goes where it is sent."""
    robot = Pair(tmp_path, "fixed").robot
    goal = robot.q_half_sitting + np.array([0.3, 0.4, 0.1])
    T = robot.at(goal).placement("left_finger")
    task = FrameAxesTask("finger", "left_finger", T, rate=4.0)
    controller = WholeBodyController.fixed(robot, tasks=[task])
    stack, q = controller.contacts, robot.q_half_sitting
    if engine == "rigid":
        plant = RigidContactEngine(robot, stack, q, controller.dt)
    else:
        pytest.importorskip("mujoco")
        from equipoise.physics.mujoco import MujocoEngine

        plant = MujocoEngine(robot, stack, q, controller.dt)
    state = plant.state
    for k in range(2500):
        state = plant.step(controller.step(k * controller.dt, state.q, state.v, state.lam).tau)
    there = robot.at(state.q).placement("left_finger").translation
    assert np.abs(there - T.translation).max() < 2e-3


MJCF = """
<mujoco><compiler angle="radian"/><worldbody><body name="base">
  <body name="upper" pos="0 0 0.3"><joint name="lift" axis="0 1 0" ref="0.2" range="-1 1"/>
    <geom size="0.05" mass="2"/>
    <body name="hand" pos="0.2 0 0.1">
      <joint name="one" axis="0 1 0" pos="0.02 0 0" ref="-0.1" range="-0.8 0.8"/>
      <geom size="0.04" pos="0.1 0 0" mass="1"/>{inside}
    </body>{beside}
  </body>
</body></worldbody>
<equality>{equality}</equality><actuator>{actuator}</actuator></mujoco>
"""
CLAW = """<body name="claw" pos="0.2 0 0">
  <joint name="two" type="slide" axis="1 0 1" ref="0.05" range="-0.5 0.5"/>
  <geom size="0.03" pos="0 0.1 0" mass="0.5"/>
</body>"""
TIE = '<joint joint1="{}" joint2="{}" polycoef="0.03 {} {} 0 0"/>'
MOTORS = '<motor joint="lift" ctrlrange="-80 80"/><motor joint="{}" ctrlrange="-50 50"/>'


def mjcf(
    folder: Path, equality: str, driven: str = "one", yaml: str = "", *, inside: bool = True
) -> Path:
    path = folder / "claw.xml"
    parts = {"inside": CLAW if inside else "", "beside": "" if inside else CLAW}
    path.write_text(MJCF.format(equality=equality, actuator=MOTORS.format(driven), **parts))
    path.with_suffix(".yaml").write_text(yaml)
    return path


@pytest.mark.parametrize("driven", ["one", "two"])
def test_equalities_of_an_mjcf_are_followed(tmp_path: Path, driven: str) -> None:
    """MuJoCo's own inertia matrix and bias, folded by its own law; who has the motor leads."""
    mujoco = pytest.importorskip("mujoco")
    inside = driven == "one"
    path = mjcf(tmp_path, TIE.format("two", "one", 0.4, 0), driven, inside=inside)
    robot, rng = load_robot(path), np.random.default_rng(2)
    assert robot.joint_names == ("lift", driven)
    model = mujoco.MjModel.from_xml_path(str(path))
    theirs, dynamics = mujoco.MjData(model), JointDynamics(robot.model)
    # q_two - 0.05 = 0.03 + 0.4 (q_one + 0.1), and the other way round
    G = np.array([[1, 0], [0, 1.0], [0, 0.4]]) @ np.diag([1.0, 1.0 if driven == "one" else 2.5])
    at = np.array([0.0, 0.0, 0.12]) if driven == "one" else np.array([0.0, -0.3, 0.0])
    for _ in range(20):
        q, v = rng.uniform(-0.3, 0.3, 2), rng.normal(size=2)
        theirs.qpos[:], theirs.qvel[:] = G @ q + at, G @ v
        model.eq_active0[:] = theirs.eq_active[:] = 0
        mujoco.mj_forward(model, theirs)
        M = np.zeros((3, 3))
        mujoco.mj_fullM(model, theirs, M)
        assert np.abs(dynamics.inertia(q) - G.T @ M @ G).max() < 1e-12
        assert np.abs(dynamics.bias(q, v) - G.T @ theirs.qfrc_bias).max() < 1e-11
        claw = robot.at(q).placement("claw").translation
        assert np.abs(claw - theirs.body("claw").xpos).max() < 1e-12


def test_who_hangs_on_another_never_leads_it(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    for tie in (("two", "one"), ("one", "two")):
        robot = load_robot(mjcf(tmp_path, TIE.format(*tie, 0.5, 0), "two"))
        assert robot.joint_names == ("lift", "one")


def test_what_is_no_law_of_one_by_another_is_told(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    bent = mjcf(tmp_path, TIE.format("two", "one", 0.4, 0.1))
    assert load_robot(bent).na == 3
    assert "of kind joint is not followed" in told(bent)
    twice = mjcf(tmp_path, TIE.format("two", "one", 0.4, 0) + TIE.format("two", "lift", 1, 0))
    assert load_robot(twice).joint_names == ("lift", "one")
    assert "of kind joint is not followed" in told(twice)
    locked = mjcf(tmp_path, TIE.format("two", "one", 0.4, 0), yaml="locked: {one: 0.2}")
    assert load_robot(locked).joint_names == ("lift",)
    apart = mjcf(tmp_path, TIE.format("two", "one", 0.4, 0), yaml="locked: {two: 0.2}")
    assert load_robot(apart).joint_names == ("lift", "one")
    held = mjcf(tmp_path, '<joint joint1="two" polycoef="0.1 0 0 0 0"/>')
    there = load_robot(held)
    assert there.joint_names == ("lift", "one")
    whole = load_robot(mjcf(tmp_path, ""))
    at = whole.at(np.array([0.2, 0.1, 0.15])).placement("claw")
    assert there.at(np.array([0.2, 0.1])).placement("claw").isApprox(at, 1e-12)


def test_the_adapter_places_who_follows(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    from equipoise.adapters.mujoco import MujocoAdapter

    path = mjcf(tmp_path, TIE.format("two", "one", 0.4, 0))
    robot, model = load_robot(path), mujoco.MjModel.from_xml_path(str(path))
    data, world = mujoco.MjData(model), MujocoAdapter(robot, model)
    world.place(data, np.array([0.1, 0.3]), np.array([0.0, 2.0]))
    assert data.joint("two").qpos[0] == pytest.approx(0.05 + 0.03 + 0.4 * 0.4)
    assert data.joint("two").qvel[0] == pytest.approx(0.8)
    assert world.from_mujoco(data).q == pytest.approx([0.1, 0.3])
    loose = mujoco.MjModel.from_xml_path(str(mjcf(tmp_path, "")))
    with pytest.raises(InputError, match=r"follows 'one'.*polycoef"):
        MujocoAdapter(robot, loose)
