"""Everyday tasks: rows against finite differences, and what a hierarchy makes of them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise import InverseKinematics
from equipoise.errors import InputError, NameNotFoundError, ScenarioError, ShapeError
from equipoise.hqp import Hierarchy
from equipoise.scenarios import named_scenarios, parse_scenario
from equipoise.simulation.build.levels import build_levels
from equipoise.simulation.build.setup import build_setup
from equipoise.spatial import pose
from equipoise.tasks import (
    ComTask,
    DampingTask,
    FrameAxesTask,
    FramePoseTask,
    JointCouplingTask,
    JointLimitsTask,
    KeepInTask,
    KeepOutTask,
    RelativeFrameTask,
)
from equipoise.trajectories import Waypoint, WaypointTrajectory
from helpers import kinematics, random_state

STEP = 1e-6
HERE = pin.SE3.Identity()
KNEES = {"LLEG_JOINT3": 1.0, "RLEG_JOINT3": -0.5}


def rate_of(robot, q, v, value):
    """Return the rate of `value(kin, t)` at t = 1 along the motion q(t), v."""
    sides = [
        value(kinematics(robot, pin.integrate(robot.model, q, v * h)), 1.0 + h)
        for h in (STEP, -STEP)
    ]
    return (sides[0] - sides[1]) / (2 * STEP)


def way_near(T, rng):
    near = T * pin.exp6(rng.normal(size=6) * 1e-3)
    return WaypointTrajectory([Waypoint(0.0, near), Waypoint(2.0, T)])


def equalities(robot, q, rng):
    kin = kinematics(robot, q)
    T = kin.placement("left_palm")
    offset = np.array([0.02, -0.05, 0.1])
    point = pin.SE3(T.rotation, T.act(offset))
    here = kin.placement("right_palm").inverse() * T
    seen = kin.placement("BODY").inverse() * kin.placement("right_palm")
    return [
        RelativeFrameTask("both", "left_palm", "right_palm", way_near(here, rng), rate=7.0),
        RelativeFrameTask(
            "some", "right_palm", "BODY", way_near(seen, rng), axes=("y", "rz"), rate=7.0
        ),
        FrameAxesTask("point", "left_palm", way_near(point, rng), offset=offset, rate=7.0),
        FrameAxesTask("turned", "left_palm", way_near(T, rng), axes=("z", "ry", "x"), rate=7.0),
        ComTask("com", way_near(pose(kin.p_world_com), rng), axes=("z", "x"), rate=7.0),
        JointCouplingTask(
            "knees", robot, [KNEES, {"RLEG_JOINT3": 1.0}], values=[0.1, 0.2], rate=7.0
        ),
    ]


@pytest.mark.parametrize("which", range(6))
def test_errors_of_equalities_decay_at_their_rate(hrp2, rng, which):
    q, _ = random_state(hrp2, rng)
    task = equalities(hrp2, q, rng)[which]
    rows = task.rows(kinematics(hrp2, q), 1.0)
    v = np.linalg.pinv(rows.A) @ rows.lower
    error = task.error(kinematics(hrp2, q), 1.0)
    assert np.array_equal(rows.lower, rows.upper)
    assert np.allclose(rate_of(hrp2, q, v, task.error), -7.0 * error, atol=2e-5)
    assert len(task.labels) == len(task.units) == len(error)


def test_all_axes_are_the_frame_task(hrp2, rng):
    """With a target that turns the six rows ask the same of v, in other axes."""
    q, _ = random_state(hrp2, rng)
    kin = kinematics(hrp2, q)
    way = WaypointTrajectory(
        [
            Waypoint(0.0, kin.placement("left_palm")),
            Waypoint(2.0, pose((0.5, 0.2, 1.0), (1, 0.2, 0))),
        ]
    )
    axes = FrameAxesTask("axes", "left_palm", way, axes=("x", "y", "z", "rx", "ry", "rz"))
    mine, theirs = axes.rows(kin, 1.0), FramePoseTask("pose", "left_palm", way).rows(kin, 1.0)
    R = way.at(1.0).T_world_target.rotation
    turn = np.kron(np.eye(2), R)
    assert np.allclose(turn @ mine.A, theirs.A)
    assert np.allclose(turn @ mine.lower, theirs.lower)


def test_volumes_bound_the_rate_of_the_room(hrp2, rng):
    q, v = random_state(hrp2, rng)
    kin = kinematics(hrp2, q)
    offset = np.array([0.0, 0.02, 0.1])
    p = kin.placement("left_palm").act(offset)
    box = KeepInTask(
        "in", "left_palm", pose(p + 0.05, (0.3, 0.2, 0.1)), (0.4, 0.5, 0.6), offset=offset, rate=4.0
    )
    ball = KeepOutTask(
        "out", "left_palm", p + np.array([0.1, 0.2, 0.0]), 0.15, offset=offset, rate=4.0
    )

    def room_in(kin, t):
        return box.faces[:, 3] - box.faces[:, :3] @ kin.placement("left_palm").act(offset)

    def room_out(kin, t):
        p = kin.placement("left_palm").act(offset)
        return np.array([np.linalg.norm(p - ball.centre) - ball.radius])

    rows = box.rows(kin, 0.0)
    assert np.allclose(rows.A @ v, -rate_of(hrp2, q, v, room_in), atol=1e-7)
    assert np.allclose(rows.upper, 4.0 * room_in(kin, 0.0))
    assert np.isinf(rows.lower).all()
    assert not box.error(kin, 0.0).any()
    rows = ball.rows(kin, 0.0)
    assert np.allclose(rows.A @ v, rate_of(hrp2, q, v, room_out), atol=1e-7)
    assert np.allclose(rows.lower, -4.0 * room_out(kin, 0.0))
    assert np.isinf(rows.upper).all()


def test_damping_asks_for_rest(hrp2, rng):
    q, v = random_state(hrp2, rng)
    kin = kinematics(hrp2, q, v)
    joints, whole = DampingTask("joints", hrp2), DampingTask("all", hrp2, base=True)
    assert np.array_equal(joints.rows(kin, 0.0).A @ v, v[6:])
    assert np.array_equal(whole.rows(kin, 0.0).A @ v, v)
    assert not joints.rows(kin, 0.0).lower.any()
    assert np.array_equal(whole.error(kin, 0.0), v)


def test_limits_bound_single_joints_and_freeze_others(hrp2):
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    task = JointLimitsTask(
        "limits", hrp2, rate=1e3, speeds={"LLEG_JOINT3": 0.1}, frozen=["RLEG_JOINT3"]
    )
    rows = task.rows(kin, 0.0)
    slow, still = hrp2.joint_index("LLEG_JOINT3"), hrp2.joint_index("RLEG_JOINT3")
    assert (rows.lower[slow], rows.upper[slow]) == (-0.1, 0.1)
    assert rows.lower[still] == rows.upper[still] == 0.0
    assert rows.upper.max() > 0.5


def test_all_of_them_in_one_tick(hrp2):
    """One kernel call; the hand stops at the box, the joint stands still, the rest is served."""
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    T, com = kin.placement("right_palm"), kin.p_world_com
    far = pose((0.3, 0.0, 0.2)) * T
    frozen = "LARM_JOINT3"
    tasks = [
        [
            KeepInTask("in", "right_palm", T, (0.3, 0.3, 0.3)),
            KeepOutTask("out", "left_palm", kin.placement("left_palm").translation, 0.05),
            JointLimitsTask("limits", hrp2, frozen=[frozen]),
        ],
        ComTask("com", com + np.array([0.01, 0.0, -0.01])),
        FrameAxesTask("hand", "right_palm", far),
        RelativeFrameTask("level", "left_palm", "BODY", kin.placement("left_palm"), axes=("rx",)),
        JointCouplingTask("elbows", hrp2, [{"LARM_JOINT4": 1.0, "RARM_JOINT4": -1.0}]),
        DampingTask("rest", hrp2),
    ]
    ik = InverseKinematics(hrp2, tasks)
    for k in range(400):
        step = ik.step()
        if k < 100:
            assert step.solution.certificate(step.hierarchy).holds()
    assert ik.motion.one_call
    errors = {t.name: t.error(step.kin, step.t) for level in ik.motion.levels for t in level}
    assert np.abs(errors["com"]).max() < 1e-5
    assert errors["in"].max() < 1e-6
    assert errors["out"].max() < 1e-6
    assert np.abs(errors["hand"]).max() > 0.02
    assert np.abs(errors["elbows"]).max() < 1e-4
    at = hrp2.nq_base + hrp2.joint_index(frozen)
    assert step.q_ref[at] == pytest.approx(hrp2.q_half_sitting[at], abs=1e-9)


def test_every_row_has_words(hrp2, rng):
    q, _ = random_state(hrp2, rng)
    kin = kinematics(hrp2, q)
    volumes = [
        KeepInTask("in", "left_palm", pose((0, 0, 1)), (1, 1, 1)),
        KeepOutTask("out", "left_palm", (0, 0, 1), 0.1),
        DampingTask("rest", hrp2),
    ]
    for task in [*equalities(hrp2, q, rng), *volumes]:
        hierarchy = Hierarchy.stack([[task.rows(kin, 1.0)]], hrp2.nv)
        words = task.describe(hierarchy.blocks[0], hierarchy)
        assert len(words) == len(hierarchy.lower)


def scenario(text):
    return parse_scenario(text, text_of=lambda name: named_scenarios()[name].read_text())


def test_scenarios_name_them():
    told = scenario(SPECS)
    tasks = {t.name: t for level in build_levels(told, build_setup(told)) for t in level}
    kinds = [
        RelativeFrameTask,
        FrameAxesTask,
        ComTask,
        JointCouplingTask,
        DampingTask,
        KeepInTask,
        KeepOutTask,
    ]
    names = ["hands", "axes", "com_height", "knees", "rest", "inside", "outside"]
    assert [type(tasks[name]) for name in names] == kinds
    assert tasks["axes"].axes == ("z", "rx")
    assert 0.0 in tasks["limits"].v_share


@pytest.mark.parametrize(
    ("old", "new", "path"),
    [
        ("LLEG_JOINT3: 1.0", "knee: 1.0", "tasks.knees.joints.knee"),
        ("LLEG_JOINT3: 0.5", "knee: 0.5", "tasks.limits.speeds.knee"),
        ("[RARM_JOINT6]", "[wrist]", "tasks.limits.frozen.0"),
    ],
)
def test_a_wrong_joint_is_told_with_its_path(old, new, path):
    told = scenario(SPECS.replace(old, new))
    with pytest.raises(ScenarioError, match=path):
        build_levels(told, build_setup(told))


SPECS = """
extends: press
tasks:
  axes:
    kind: frame_axes
    frame: right_palm
    axes: [z, rx]
    priority: 2
    waypoints: [{t: 0.0, xyz: [0.3, -0.3, 1.0]}]
  hands:
    kind: relative_frame
    frame: left_palm
    relative_to: right_palm
    priority: 2
    waypoints: [{t: 0.0, xyz: [0.0, 0.0, 0.5]}]
  com_height: {kind: com_point, axes: [z], priority: 2, waypoints: [{t: 0.0, xyz: [0.0, 0.0, 0.8]}]}
  knees: {kind: joint_coupling, priority: 2, joints: {LLEG_JOINT3: 1.0, RLEG_JOINT3: -1.0}}
  rest: {kind: damping, priority: 4}
  inside: {kind: keep_in, frame: right_palm, priority: 1, at: {xyz: [0.3, 0, 1]}, size: [1, 1, 1]}
  outside: {kind: keep_out, frame: right_palm, priority: 1, at: {xyz: [0.3, 0.2, 1]}, radius: 0.1}
  limits: {kind: joint_limits, priority: 1, speeds: {LLEG_JOINT3: 0.5}, frozen: [RARM_JOINT6]}
"""


@pytest.mark.parametrize(
    ("how", "error", "says"),
    [
        (lambda r: FrameAxesTask("a", "left_palm", HERE, axes=["w"]), NameNotFoundError, "w"),
        (lambda r: FrameAxesTask("a", "left_palm", HERE, axes=[]), InputError, "axes"),
        (lambda r: RelativeFrameTask("r", "head", "head", HERE), InputError, "two frames"),
        (lambda r: ComTask("c", (0, 0)), ShapeError, "xyz"),
        (lambda r: ComTask("c", (0, 0, 1), axes=["rx"]), NameNotFoundError, "rx"),
        (lambda r: JointCouplingTask("j", r, [{"elbow": 1.0}]), NameNotFoundError, "elbow"),
        (lambda r: JointCouplingTask("j", r, KNEES), InputError, "sums"),
        (lambda r: JointCouplingTask("j", r, [KNEES], values=[0, 1]), ShapeError, r"wanted \(1,\)"),
        (lambda r: KeepInTask("i", "left_palm", HERE, (1, 0, 1)), InputError, "size"),
        (lambda r: KeepOutTask("o", "left_palm", (0, 0, 0), 0.0), InputError, "radius"),
        (lambda r: JointLimitsTask("l", r, speeds={"elbow": 1.0}), NameNotFoundError, "elbow"),
        (lambda r: JointLimitsTask("l", r, speeds={"LLEG_JOINT3": -1.0}), InputError, "negative"),
        (lambda r: JointLimitsTask("l", r, frozen="LLEG_JOINT3"), InputError, "list"),
    ],
)  # fmt: skip
def test_errors_say_what_was_given(hrp2, how, error, says):
    with pytest.raises(error, match=says):
        how(hrp2)
