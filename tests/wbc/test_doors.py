"""The doors: a robot that stands, one that is fixed, and what is set while they run."""

from __future__ import annotations

import threading

import numpy as np
import pinocchio as pin
import pytest

from equipoise import InverseKinematics, LoopSettings, RigidContactEngine, WholeBodyController
from equipoise.contacts import PointContact, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.control import BoundedDistribution, DistributionStatus
from equipoise.control.passivity.gain_advice import inertia_matrix
from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.robots import Robot
from equipoise.spatial import pose
from equipoise.tasks import FramePoseTask, PostureTask
from equipoise.trajectories import FixedPose, Profile
from fixed_arm import small_arm
from helpers import kinematics

RIGID = LoopSettings(delay=0.0)


@pytest.fixture
def arm() -> Robot:
    return small_arm()


def follow(controller, engine, seconds, each=lambda k: None):
    """Run a loop in the rigid engine; return the last command and state."""
    state = engine.state
    for k in range(round(seconds / controller.dt)):
        each(k)
        command = controller.step(k * controller.dt, state.q, state.v, state.lam)
        state = engine.step(command.tau)
    return command, state


def wall_at(robot: Robot, frame: str) -> SurfaceContact:
    """Return a wall before a frame, its normal against x."""
    kin = kinematics(robot, robot.q_half_sitting)
    return SurfaceContact.on_plane("wall", frame, kin, (-2.0, 0.0, 0.0))


def test_a_robot_stands_and_presses(hrp2):
    controller = WholeBodyController.standing(
        hrp2, contacts=[wall_at(hrp2, "right_palm")], forces={"wall": 20.0}
    )
    names = [[task.name for task in level] for level in controller.motion.levels]
    assert names == [["contacts"], ["limits", "balance"], ["posture"]]
    engine = RigidContactEngine(hrp2, controller.contacts, hrp2.q_half_sitting, controller.dt)
    _, state = follow(controller, engine, 1.5)
    assert state.lam[controller.contacts.rows["wall"]][0] == pytest.approx(20.0, abs=0.1)
    assert np.abs(pin.difference(hrp2.model, hrp2.q_half_sitting, state.q)).max() < 1e-3


def test_a_force_is_set_while_it_runs_and_never_jumps(hrp2):
    controller = WholeBodyController.standing(
        hrp2, contacts=[wall_at(hrp2, "right_palm")], forces={"wall": 10.0}, loop=RIGID
    )
    engine = RigidContactEngine(hrp2, controller.contacts, hrp2.q_half_sitting, controller.dt)
    wanted = []

    def each(k):
        if k == 700:
            controller.want("wall", 25.0)
        if k:
            wanted.append(controller.wanted[0])

    _, state = follow(controller, engine, 1.6, each)
    assert wanted[0] < 0.01  # the first one is faded too
    assert wanted[690] == 10.0
    assert wanted[-1] == 25.0
    assert np.abs(np.diff(wanted)).max() < 15.0 * 1.9 / 500
    assert state.lam[controller.contacts.rows["wall"]][0] == pytest.approx(25.0, abs=0.1)
    with pytest.raises(InputError, match="can only push"):
        controller.want("wall/fn", -1.0)
    with pytest.raises(NameNotFoundError, match="floor"):
        controller.want("floor", 1.0)
    fixed = WholeBodyController.standing(
        hrp2, contacts=[wall_at(hrp2, "right_palm")], forces={"wall": Profile.of([0], [5.0])}
    )
    with pytest.raises(InputError, match="function of time"):
        fixed.want("wall", 1.0)


def test_memory_holds_what_was_set(hrp2):
    """Two that go on from one state, with a target and a force on their way, give the same bits."""
    T = kinematics(hrp2, hrp2.q_half_sitting).placement("left_palm")
    task = FramePoseTask("hand", "left_palm", T)
    controller = WholeBodyController.standing(
        hrp2, tasks=[task], contacts=[wall_at(hrp2, "right_palm")], forces={"wall": 10.0}
    )
    q, v, lam = hrp2.q_half_sitting, np.zeros(hrp2.nv), np.zeros(controller.contacts.size)
    for k in range(20):
        if k == 10:
            task.target = pose((0.0, 0.0, 0.1)) * T
            controller.want("wall", 14.0)
        controller.step(k * 1e-3, q, v, lam)
    kept = controller.state()
    first = [controller.step(k * 1e-3, q, v, lam).result.copy() for k in range(20, 60)]
    controller.restore(kept)
    again = [controller.step(k * 1e-3, q, v, lam).result.copy() for k in range(20, 60)]
    assert np.array_equal(first, again)
    assert not np.array_equal(first[0], first[-1])


def test_a_target_set_by_another_thread_is_followed(hrp2):
    T = kinematics(hrp2, hrp2.q_half_sitting).placement("left_palm")
    controller = WholeBodyController.standing(
        hrp2, tasks=[FramePoseTask("hand", "left_palm", T)], loop=RIGID
    )
    there = pose((0.05, 0.05, 0.1)) * T

    def set_it():
        controller.task("hand").target = there

    def each(k):
        if k == 50:
            thread = threading.Thread(target=set_it)
            thread.start()
            thread.join()

    engine = RigidContactEngine(hrp2, controller.contacts, hrp2.q_half_sitting, controller.dt)
    _command, state = follow(controller, engine, 1.5, each)
    assert controller._fused
    here = kinematics(hrp2, state.q).placement("left_palm")
    assert np.abs(here.translation - there.translation).max() < 1e-4
    with pytest.raises(NameNotFoundError, match="foot"):
        controller.task("foot")


def test_feet_that_are_points_carry_within_bounds(hrp2):
    """Six points stand for the soles: the robot stands on them, pressing with each."""
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    feet = [
        PointContact(
            name=f"{sole.name}{k}", supporting=True, frame=sole.frame, offset=tuple(corner),
            p_world=kin.placement(sole.frame).act(corner),
        )
        for sole in hrp2.soles for k, corner in enumerate(sole.corners[:3])
    ]  # fmt: skip
    share = BoundedDistribution(feet)
    J = np.vstack([foot.jacobian(kin)[:, :6] for foot in feet])
    weight = 9.81 * hrp2.mass
    com = kin.p_world_com
    R = kin.placement("BODY").rotation if "BODY" in hrp2.frame_names else np.eye(3)
    force, lever = R.T @ [0, 0, weight], R.T @ (com - hrp2.q_half_sitting[:3])
    wrench = np.concatenate((force, np.cross(lever, force)))
    found = share(wrench, J, np.zeros(18))
    assert found.status is DistributionStatus.POSSIBLE
    assert np.allclose(J.T @ found.F, wrench, atol=1e-6)
    pressed = found.predicted.reshape(6, 3)
    assert pressed[:, 2].min() >= 10.0 - 1e-6
    assert (np.hypot(pressed[:, 0], pressed[:, 1]) <= 0.63 * pressed[:, 2] + 1e-6).all()


def test_frames_named_as_feet_stand_as_points(hrp2):
    names = [hrp2.soles[0].name, hrp2.soles[1].frame]
    frame = next(
        n for n in hrp2.frame_names if n not in [s.name for s in hrp2.soles] and "LEG" in n
    )
    controller = WholeBodyController.standing(hrp2, feet=[names[0], frame])
    kinds = [type(contact).__name__ for contact in controller.contacts.contacts]
    assert kinds == ["SoleContact", "PointContact"]
    q, v = hrp2.q_half_sitting, np.zeros(hrp2.nv)
    command = controller.step(0.0, q, v, np.zeros(controller.contacts.size))
    assert np.isfinite(command.tau).all()


def test_own_tasks_stand_between_and_replace(hrp2):
    q = hrp2.q_half_sitting
    mine = PostureTask("mine", hrp2, q[7:] + 0.01, rate=2.0)
    hands = [FramePoseTask(p.name, p.frame, FixedPose(pose((0.4, 0, 1)))) for p in hrp2.palms]
    controller = WholeBodyController.standing(hrp2, tasks=[hands, mine])
    names = [[task.name for task in level] for level in controller.motion.levels]
    assert names == [["contacts"], ["limits", "balance"], [p.name for p in hrp2.palms], ["mine"]]


def test_a_fixed_arm_moves_and_presses(arm):
    """Nothing supports it, nothing is balanced; masses of 130 % are found by the law."""
    T = arm.at(arm.q_half_sitting).placement("tip")
    task = FramePoseTask("tip", "tip", T)
    controller = WholeBodyController.fixed(arm, tasks=[task])
    assert [level[0].name for level in controller.motion.levels] == ["limits", "tip", "posture"]
    heavy = small_arm()
    for joint in range(1, 4):
        inertia = heavy.model.inertias[joint]
        heavy.model.inertias[joint] = pin.Inertia(
            1.3 * inertia.mass, inertia.lever, 1.3 * inertia.inertia
        )
    there = arm.q_half_sitting + np.array([0.2, -0.1, 0.05])
    task.target = arm.at(there).placement("tip")
    engine = RigidContactEngine(heavy, controller.contacts, arm.q_half_sitting, controller.dt)
    command, state = follow(controller, engine, 4.0)
    assert controller._fused
    assert command.base_reaction.size == 0
    assert np.abs(state.q - there).max() < 1e-4
    assert np.abs(state.q - command.q_ref).max() < 1e-4


def test_a_fixed_arm_presses(arm):
    p = arm.at(arm.q_half_sitting).placement("tip").translation
    table = SurfaceContact(
        name="table", frame="tip", surface=Plane(), T_world_surface=pose(p), regulated=("fn",)
    )
    controller = WholeBodyController.fixed(
        arm, contacts=[table], forces={"table": 10.0}, loop=RIGID
    )
    engine = RigidContactEngine(arm, controller.contacts, arm.q_half_sitting, controller.dt)
    _, state = follow(controller, engine, 2.0)
    assert state.lam[0] == pytest.approx(10.0, abs=0.05)


def test_each_door_refuses_what_belongs_to_the_other(hrp2, arm):
    with pytest.raises(InputError, match="fixed to the world"):
        WholeBodyController.standing(arm)
    with pytest.raises(InputError, match="base of robot hrp2 moves"):
        WholeBodyController.fixed(hrp2)


@pytest.mark.parametrize(
    ("how", "error", "says"),
    [
        ({"feet": "left"}, InputError, "list of names"),
        ({"feet": ["hoof"]}, NameNotFoundError, "hoof"),
        ({"feet": []}, InputError, "no contact supports the base"),
        ({"tasks": ["hand"]}, InputError, "a level is a task"),
        ({"forces": {"wall": 3.0}}, NameNotFoundError, "wall"),
        ({"q_start": np.zeros(3)}, ShapeError, "q_start"),
        ({"loop": LoopSettings(rotor_inertia=np.zeros(4))}, ShapeError, "rotor inertia"),
    ],
)
def test_errors_say_what_was_given(hrp2, how, error, says):
    with pytest.raises(error, match=says):
        WholeBodyController.standing(hrp2, **how)


@pytest.mark.parametrize(
    "how",
    [{"period": 0.0}, {"delay": -1.0}, {"margin": -0.1}, {"rotor_inertia": -0.1}, {"shape": "no"}],
)
def test_a_loop_that_cannot_be_is_refused(how):
    with pytest.raises(InputError):
        LoopSettings(**how)


def test_a_gain_of_postures_is_slower_with_stretched_arms(hrp2):
    """The fastest rate of M^-1 K_d, which sampled damping has to survive, on a fixed base."""
    rates = {}
    for shape in ("start", "postures"):
        loop = LoopSettings(delay=0.0015, shape=shape)
        K_d = WholeBodyController.standing(hrp2, loop=loop).settings.gains.K_d
        q = hrp2.q_half_sitting.copy()
        q[[7 + hrp2.joint_index(name) for name in ("RARM_JOINT3", "LARM_JOINT3")]] = 0.0
        M = inertia_matrix(hrp2, q)[6:, 6:]
        rates[shape] = np.abs(np.linalg.eigvals(np.linalg.solve(M, np.array(K_d)[6:, 6:]))).max()
    assert rates["postures"] < rates["start"]


@pytest.mark.parametrize(
    "bounds", [4.0, {"RARM_JOINT3": 4.0}, "all"], ids=["one", "by_name", "each"]
)
def test_accelerations_are_bounded_at_the_doors(hrp2, bounds):
    """A far target is not jumped at: no bounded joint of the reference speeds up faster."""
    most = np.full(hrp2.na, 6.0) if bounds == "all" else bounds
    T = kinematics(hrp2, hrp2.q_half_sitting).placement("right_palm")
    hand = FramePoseTask("hand", "right_palm", FixedPose(pose((0.1, 0.0, 0.2)) * T))
    loop = LoopSettings(delay=0.0, accelerations=most)
    controller = WholeBodyController.standing(hrp2, tasks=[hand], loop=loop)
    names = [[task.name for task in level] for level in controller.motion.levels]
    assert names[:2] == [["contacts"], ["accelerations"]]
    ik = InverseKinematics(hrp2, [hand], period=0.005, accelerations=most)
    speeds = np.array([ik.step().v_ref[6:] for _ in range(60)])
    changes = np.abs(np.diff(speeds, axis=0)).max(axis=0) / 0.005
    joint = hrp2.joint_names.index("RARM_JOINT3")
    if isinstance(bounds, dict):
        assert changes[joint] <= 4.0 + 1e-6 < changes.max()
    else:
        assert changes.max() <= (6.0 if bounds == "all" else 4.0) + 1e-6
    free = InverseKinematics(hrp2, [hand], period=0.005)
    jump = abs(free.step().v_ref[6:][joint]) / 0.005
    assert jump > 6.0
    with pytest.raises(NameNotFoundError, match="elbow"):
        InverseKinematics(hrp2, [hand], accelerations={"elbow": 1.0})
