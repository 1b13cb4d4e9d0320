"""What a discrete loop cannot follow is refused, or told, where it is given."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import ContactStack, SoleContact, SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.control import (
    ControlGains,
    PassivityController,
    ReactionBounds,
    SignFunction,
    advise_for_soft_floor,
    advise_gains,
)
from equipoise.control.base_wrench.observer import ReactionObserver, observer_gain
from equipoise.errors import AdviceWarning, InputError
from equipoise.hqp import Rows, make_solver
from equipoise.motion import MotionGenerator, PostureNotFoundError, solve_posture
from equipoise.physics import RigidContactEngine, RigidOptions
from equipoise.simulation.faults import DelayLine
from equipoise.spatial import pose
from equipoise.tasks import (
    AvoidanceTask,
    ComPolygonTask,
    ContactTask,
    FramePoseTask,
    GazeTask,
    JointLimitsTask,
    PostureTask,
    Task,
)
from equipoise.trajectories import FixedPose
from equipoise.wbc import ControlSettings
from helpers import kinematics, sole_contacts

NO_PERIOD = [0.0, -0.001, np.nan, np.inf, -np.inf, "0.001", None, True]
NO_RATE = [0.0, -1.0, np.nan, np.inf, "5", None]
NO_SHARE = [0.0, -0.5, 1.5, np.nan, np.inf]
PERIOD = 0.05


def polygon_of(robot):
    contacts = sole_contacts(robot, robot.q_half_sitting)
    return SupportPolygon.of_points(
        np.vstack([sole_corners(c.sole, c.T_world_anchor) for c in contacts])
    )


def wall(robot):
    shape = Shape("box", (0.1, 2.0, 2.0), pose((0.0, 0.0, 0.0)))
    return Scene(robot, [Body("wall", (shape,), pose((2.0, 0.0, 1.0)))])


def avoid(robot, slope):
    scene = wall(robot)
    pair = scene.pair("HEAD_LINK1", "wall")
    return AvoidanceTask("t", scene, [pair], influence=0.1, security=0.05, damping=0.05 * slope)


MAKERS = {
    "pose": lambda robot, rate: FramePoseTask(
        "t", "left_palm", FixedPose(pose((1, 0, 1))), rate=rate
    ),
    "gaze": lambda robot, rate: GazeTask("t", robot.camera, FixedPose(pose((3, 0, 1))), rate=rate),
    "balance": lambda robot, rate: ComPolygonTask("t", polygon_of(robot), rate=rate),
    "limits": lambda robot, rate: JointLimitsTask("t", robot, rate=rate),
    "posture": lambda robot, rate: PostureTask("t", robot, robot.q_half_sitting[7:], rate=rate),
    "contacts": lambda robot, rate: ContactTask(
        "t", ContactStack(sole_contacts(robot, robot.q_half_sitting)), rate=rate
    ),
    "avoidance": avoid,
}


def generator(robot, task, period):
    return MotionGenerator(
        robot, [[task]], make_solver("active_set"), period, robot.q_half_sitting, advise=False
    )


@pytest.mark.parametrize("kind", MAKERS)
def test_a_task_that_would_overshoot_in_one_period_is_refused(hrp2, kind):
    generator(hrp2, MAKERS[kind](hrp2, 1.0 / PERIOD), PERIOD)  # dead beat: just what is possible
    with pytest.raises(InputError, match=r"rate of at most 20 1/s, or a period of at most 0\.049"):
        generator(hrp2, MAKERS[kind](hrp2, 1.01 / PERIOD), PERIOD)


@pytest.mark.parametrize("kind", [k for k in MAKERS if k != "avoidance"])
@pytest.mark.parametrize("rate", NO_RATE)
def test_a_rate_that_is_none_is_refused_by_its_task(hrp2, kind, rate):
    with pytest.raises(InputError, match="rate of task 't' must be finite and positive"):
        MAKERS[kind](hrp2, rate)


def test_a_task_of_ones_own_is_asked_for_its_rate(hrp2):
    class Own(Task):
        rate = 30.0
        labels = units = ("x",)

        def rows(self, kin, t):
            raise AssertionError("it is refused before it is asked")

        error = rows

    with pytest.raises(InputError, match=r"30 1/s \* 0.05 s = 1.5 > 1"):
        generator(hrp2, Own("own"), PERIOD)


@pytest.mark.parametrize("dt", NO_PERIOD)
def test_a_period_that_is_none_is_refused_wherever_one_is_given(hrp2, dt):
    contacts, q = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting)), hrp2.q_half_sitting
    posture = PostureTask("p", hrp2, q[7:])
    solver = make_solver("active_set")
    for make in (
        lambda: MotionGenerator(hrp2, [[posture]], solver, dt, q),
        lambda: solve_posture(hrp2, [[posture]], solver, q, t_from=0.0, step=dt),
        lambda: PassivityController(hrp2, contacts, ControlGains(K_d=1.0), dt),
        lambda: RigidContactEngine(hrp2, contacts, q, dt),
        lambda: advise_gains(hrp2, contacts, q, dt, alpha=20.0),
        lambda: advise_for_soft_floor(0.003, dt, 5.0),
        lambda: observer_gain(0.02, dt),
        lambda: DelayLine(0.003, dt),
    ):
        with pytest.raises(InputError, match=r"period must be (finite and positive|a real number)"):
            make()


@pytest.mark.parametrize("share", NO_SHARE)
def test_a_share_that_is_none_is_refused(hrp2, share):
    contacts, q = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting)), hrp2.q_half_sitting
    for make in (
        lambda: JointLimitsTask("l", hrp2, velocity_share=share),
        lambda: advise_gains(hrp2, contacts, q, 0.001, alpha=20.0, share=share),
        lambda: ReactionBounds(friction_share=share),
    ):
        with pytest.raises(InputError, match="must be in"):
            make()


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf])
def test_numbers_of_the_wrong_sign_are_refused(hrp2, value):
    contacts, q = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting)), hrp2.q_half_sitting
    sole = contacts.contacts[0]
    for make in (
        lambda: JointLimitsTask("l", hrp2, margin=value),
        lambda: ComPolygonTask("c", polygon_of(hrp2), margin=value),
        lambda: advise_gains(hrp2, contacts, q, 0.001, alpha=value),
        lambda: advise_gains(hrp2, contacts, q, 0.001, alpha=20.0, kappa=value),
        lambda: advise_gains(hrp2, contacts, q, 0.001, alpha=20.0, rotor_inertia=value),
        lambda: advise_for_soft_floor(value, 0.001, 5.0),
        lambda: ReactionObserver(value, 0.001),
        lambda: PassivityController(
            hrp2, contacts, ControlGains(K_d=1.0), 0.001, filter_time=value
        ),
        lambda: ReactionBounds(normal_min=value),
        lambda: RigidOptions(velocity_gain=value),
        lambda: SignFunction("tanh", value),
        lambda: DelayLine(value, 0.001),
        lambda: SoleContact(
            name="s", sole=sole.sole, T_world_anchor=sole.T_world_anchor, friction=value
        ),
    ):
        with pytest.raises(InputError, match=r"must be (finite and|positive)|is not finite"):
            make()


def test_gains_that_would_overshoot_in_one_period_are_refused(hrp2):
    contacts = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    for name in ("alpha", "beta_p", "beta_F", "eta"):
        gains = ControlGains(K_d=1.0, **{name: 101.0})
        with pytest.raises(InputError, match=f"gain {name} is too fast for the period"):
            PassivityController(hrp2, contacts, gains, 0.01)
    law = PassivityController(hrp2, contacts, ControlGains(K_d=1.0), 0.01)
    with pytest.raises(InputError, match="gain alpha is too fast"):
        law.gains = ControlGains(K_d=1.0, alpha=101.0)
    assert law.gains.alpha == 20.0


def test_a_posture_of_fast_tasks_is_found_with_shorter_steps(hrp2):
    wanted = hrp2.q_half_sitting[7:] + 0.05
    fast = PostureTask("p", hrp2, wanted, rate=400.0)
    levels = [[fast]]
    q = solve_posture(hrp2, levels, make_solver("active_set"), hrp2.q_half_sitting, t_from=0.0)
    np.testing.assert_allclose(q[7:], wanted, atol=1e-6)


class Turning(Task):
    """Wants a joint to go on for ever."""

    labels = units = ("x",)

    def rows(self, kin, t):
        A = np.zeros((1, kin.robot.nv))
        A[0, -1] = 1.0
        return Rows("turning", "rad/s", ("x",), A, np.array([0.3]), np.array([0.3]))

    def error(self, kin, t):
        return np.zeros(1)


def test_a_posture_that_never_comes_to_rest_is_refused(hrp2):
    levels = [[Turning("turning")]]
    with pytest.raises(PostureNotFoundError, match=r"after 60 s .* still moves with 0.3 rad/s"):
        solve_posture(hrp2, levels, make_solver("active_set"), hrp2.q_half_sitting, t_from=0.0)


@pytest.mark.parametrize("faster", [0.99, 1.01])
def test_a_balance_rate_that_a_floor_cannot_brake_is_told_once(hrp2, faster):
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    height = kin.p_world_com[2] - kin.placement(hrp2.soles[0].frame).translation[2]
    rate = faster * np.sqrt(9.81 / height)
    task = ComPolygonTask("balance", polygon_of(hrp2), rate=rate)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        motion = MotionGenerator(
            hrp2, [[task]], make_solver("active_set"), 0.01, hrp2.q_half_sitting
        )
        motion.step(0.0)
    sentences = [str(one.message) for one in told if one.category is AdviceWarning]
    assert len(sentences) == (faster > 1.0)
    assert all(
        "'balance'" in s and f"at most {np.floor(10.0 * rate / faster) / 10.0:g} 1/s" in s
        for s in sentences
    )


def test_the_period_of_a_controller_is_refused_with_its_tasks(hrp2):
    from equipoise.wbc import WholeBodyController

    contacts = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    levels = [[ContactTask("c", contacts, rate=200.0)]]
    settings = ControlSettings(ControlGains(K_d=1.0), period=0.01)
    with pytest.raises(InputError, match="task 'c' is too fast"):
        WholeBodyController(hrp2, levels, contacts, settings, hrp2.q_half_sitting)
