"""Whatever is given for an argument by mistake, the answer is an error of ours that says so.

Every argument of the doors, the tasks, the planning of walks and the estimators is replaced by
values of the wrong class, shape, sign or size, one at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from equipoise import ContactStack, InverseKinematics, WholeBodyController, get_robot, make_solver
from equipoise import tasks as of_tasks
from equipoise.errors import EquipoiseError, InputError
from equipoise.estimation import BaseFilter, FilterNoise, WrenchObserver
from equipoise.motion.levels import feet_of, polygon_of
from equipoise.spatial import pose
from equipoise.walking import (
    BalanceFeedback,
    BalanceSettings,
    Feet,
    Footstep,
    Stride,
    StrideLimits,
    Swing,
    SwingShape,
    TouchSettings,
    WalkClock,
    WalkMode,
    WalkPlanner,
    WalkSettings,
    WalkTiming,
    closing_step,
    steps_along,
    steps_to,
)
from equipoise.wbc import LoopSettings

ROBOT = get_robot("hrp2")
Q = ROBOT.q_half_sitting
KIN = ROBOT.at(Q)
PALM = KIN.placement("right_palm").copy()
SOLES = feet_of(ROBOT, Q, None, 0.7)
POLYGON = polygon_of(SOLES)
FEET = Feet.of(ROBOT)
STANCE = tuple(KIN.placement(sole.frame).copy() for sole in FEET.soles)
FIRST, SECOND = ROBOT.joint_names[:2]

WRONG: list[Any] = [
    float("nan"), float("inf"), -1.0, 1e300, 7, True, 1 + 2j, None, "x", [], [1], ["zz"], {},
    {"zz": 1.0}, np.array([1.0, np.nan]), np.eye(3), np.array(["a"]), pin.SE3.Identity(),
    pin.SE3(np.diag([1.0, 1.0, -1.0]), np.zeros(3)), lambda t: t,
]  # fmt: skip

PLANNER = WalkPlanner(FEET, WalkSettings(0.8))
STEPS = steps_along(FEET, STANCE, Stride(0.1), 3)
FRAMES = {"frame": "right_palm", "target": PALM, "rate": 5.0}
AIMED = {**FRAMES, "axes": ("x", "y")}
OF_JOINTS = {"robot": ROBOT, "margin": 0.01, "velocity_share": 0.9, "rate": 5.0}

CALLS: dict[Callable[..., Any], dict[str, Any]] = {
    LoopSettings: {"period": 1e-3, "delay": 3e-3, "rotor_inertia": 0.1, "margin": 0.02,
                   "observer": 0.02},
    make_solver: {"name": "active_set"},
    InverseKinematics: {"robot": ROBOT, "tasks": (), "q_start": Q, "period": 0.01, "feet": None,
                        "accelerations": 50.0, "solver": "active_set"},
    WholeBodyController.standing: {"robot": ROBOT, "q_start": Q, "tasks": (), "forces": None,
                                   "feet": None},
    of_tasks.ComTask: {"target": KIN.p_world_com.copy(), "axes": ("x", "y"), "rate": 5.0},
    of_tasks.ComPolygonTask: {"polygon": POLYGON, "margin": 0.01, "rate": 2.0},
    of_tasks.ContactTask: {"contacts": ContactStack(SOLES), "rate": 5.0},
    of_tasks.DampingTask: {"robot": ROBOT, "base": False},
    of_tasks.FloorSupportTask: {"robot": ROBOT, "polygon": POLYGON, "period": 0.005, "height": 0.0,
                                "margin": 0.01, "least": 0.3},
    of_tasks.FrameAxesTask: {**AIMED, "offset": (0.0, 0.0, 0.01)},
    of_tasks.FramePoseTask: {**FRAMES, "reach": of_tasks.Reach(ROBOT, 0.005)},
    of_tasks.Reach: {"robot": ROBOT, "period": 0.005, "pull": 0.3, "pull_turn": 0.6, "damping": 0.2,
                     "mass": 0.01, "weights": 1.0, "change": 30.0, "fastest": 2.0,
                     "close": 0.005, "home": Q[7:], "homing": 0.1},
    of_tasks.GazeTask: {"camera": "right_palm", "target": pose((2.0, 0.0, 1.0)), "rate": 5.0},
    of_tasks.JointAccelerationsTask: {**OF_JOINTS, "acceleration": np.full(ROBOT.na, 50.0),
                                      "period": 0.005},
    of_tasks.JointCouplingTask: {"robot": ROBOT, "sums": [{FIRST: 1.0, SECOND: -1.0}],
                                 "values": [0.0], "rate": 5.0},
    of_tasks.JointLimitsTask: {**OF_JOINTS, "speeds": {FIRST: 1.0}, "frozen": [SECOND]},
    of_tasks.KeepInTask: {"frame": "right_palm", "T_world_box": PALM, "size": (0.2, 0.2, 0.2),
                          "offset": (0.0, 0.0, 0.0), "rate": 5.0},
    of_tasks.KeepOutTask: {"frame": "right_palm", "centre": PALM.translation + 0.3, "radius": 0.1,
                           "offset": (0.0, 0.0, 0.0), "rate": 5.0},
    of_tasks.PostureTask: {"robot": ROBOT, "q_joints": Q[7:], "rate": 1.0},
    of_tasks.RelativeFrameTask: {**AIMED, "relative_to": "left_palm"},
    Footstep: {"foot": 0, "T_world_sole": PALM},
    Stride: {"forward": 0.1, "left": 0.0, "turn": 0.0, "up": 0.0},
    StrideLimits: {"forward": 0.1, "side": 0.1, "turn": 0.1},
    SwingShape: {"height": 0.05, "touchdown": 0.03, "search": 0.04},
    Swing: {"T_from": STANCE[0], "T_to": STANCE[1], "lift": 0.0, "land": 0.5,
            "shape": SwingShape()},
    TouchSettings: {"load": 10.0, "earliest": 0.5, "glide": 0.1, "level": 0.005},
    WalkClock: {"start": 0.0, "fall": 0.1, "least": 0.1},
    WalkSettings: {"height": 0.8, "mode": WalkMode.SLOW, "timing": WalkTiming(),
                   "swing": SwingShape(), "inward": 0.0, "leg": 0.0},
    BalanceSettings: {"gain": 3.0, "margin": 0.01, "leash": 0.01},
    BalanceFeedback: {"settings": BalanceSettings()},
    steps_along: {"feet": FEET, "stance": STANCE, "stride": Stride(0.1), "count": 3, "first": 0},
    steps_to: {"feet": FEET, "stance": STANCE, "goal": (0.5, 0.0, 0.0), "limits": StrideLimits()},
    closing_step: {"feet": FEET, "stance": STANCE, "foot": 0,
                   "apart": STANCE[1].actInv(STANCE[0])},
    PLANNER.begin: {"stance": STANCE, "steps": STEPS, "start": 0.0},
    FilterNoise: {"rate": 1e-3, "slip": 1e-3},
    BaseFilter: {"robot": ROBOT, "soles": SOLES, "noise": FilterNoise()},
    WrenchObserver: {"robot": ROBOT, "filter_time": 0.01, "rotor_inertia": 0.1},
}  # fmt: skip
NAMED = (of_tasks.Task,)
ALSO = {BalanceFeedback: {"omega": 3.0, "dt": 1e-3}}


def name_of(call):
    return getattr(call, "__qualname__", str(call))


@pytest.mark.parametrize("call", CALLS, ids=name_of)
def test_a_wrong_argument_is_never_somebody_elses_error(call):
    good, more = dict(CALLS[call]), dict(ALSO.get(call, {}))
    if isinstance(call, type) and issubclass(call, NAMED):
        good["name"] = "a task"
    call(**good, **more)  # what is right is taken
    for argument in good:
        for wrong in WRONG:
            try:
                call(**{**good, argument: wrong}, **more)
            except EquipoiseError:
                continue
            except Exception as error:
                pytest.fail(f"{argument} = {wrong!r}: {type(error).__name__}: {error}")


@pytest.mark.parametrize("margin", [0.5, 7.0])
def test_a_margin_that_leaves_nothing_of_the_support_is_refused(margin):
    with pytest.raises(InputError, match="leaves nothing"):
        WholeBodyController.standing(ROBOT, loop=LoopSettings(margin=margin))


def test_the_largest_margin_is_the_radius_of_the_largest_circle_inside():
    """In a rectangle half its shorter side, in a triangle two areas over the way round."""
    made = type(POLYGON).of_points
    box = made(np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 0.1], [0.0, 0.1]]))
    triangle = made(np.array([[0.0, 0.0], [0.4, 0.0], [0.0, 0.3]]))
    for polygon, radius in ((box, 0.05), (triangle, 0.4 * 0.3 / (0.4 + 0.3 + 0.5))):
        assert polygon.holds_margin(radius * (1.0 - 1e-9))
        assert not polygon.holds_margin(radius * (1.0 + 1e-9))


@pytest.mark.parametrize("delay", [0.2, 3.0])
def test_a_delay_in_milliseconds_is_noticed(delay):
    with pytest.raises(InputError, match="in seconds"):
        WholeBodyController.standing(ROBOT, loop=LoopSettings(delay=delay))


class TestALoopThatGivesNonsense:
    def setup_method(self):
        self.controller = WholeBodyController.standing(ROBOT)
        self.v = np.zeros(ROBOT.nv)
        self.wrenches = {name: np.zeros(6) for name in self.controller.contacts.rows}

    @pytest.mark.parametrize("t", [float("nan"), float("inf"), "x", None, [0.0]])
    def test_a_time_that_is_none_is_refused_before_anything_happens(self, t):
        """A clock that gave NaN made torques of NaN before."""
        before = self.controller.state()
        with pytest.raises(InputError):
            self.controller.step(t, Q, self.v, self.wrenches)
        require_same(self.controller.state(), before)
        assert np.isfinite(self.controller.step(0.0, Q, self.v, self.wrenches).tau).all()

    @pytest.mark.parametrize("wrench", [1.0, None, "abcdef", np.zeros(5), [[0.0] * 6]])
    def test_a_wrench_of_the_wrong_shape_names_its_contact(self, wrench):
        name = next(iter(self.wrenches))
        with pytest.raises(InputError, match=name):
            self.controller.step(0.0, Q, self.v, {**self.wrenches, name: wrench})

    @pytest.mark.parametrize("state", [None, {}, {"workspace": 1}, "x"])
    def test_a_state_that_is_none_changes_nothing(self, state):
        before = self.controller.state()
        with pytest.raises(InputError, match="no state"):
            self.controller.restore(state)
        require_same(self.controller.state(), before)

    def test_the_state_of_another_robot_changes_nothing(self):
        before = self.controller.state()
        other = WholeBodyController.standing(get_robot("g1"))
        with pytest.raises(InputError, match="no state"):
            self.controller.restore(other.state())
        require_same(self.controller.state(), before)

    @pytest.mark.parametrize("supports", [None, 3, "left_sole", [3], ["nobody"], []])
    def test_a_refused_switch_changes_nothing(self, supports):
        before = self.controller.state()
        with pytest.raises(InputError):
            self.controller.switch(supports)
        require_same(self.controller.state(), before)

    def test_a_refused_anchor_changes_nothing_of_those_beside_it(self):
        names = list(self.wrenches)
        before = self.controller.supports.state()
        mirrored = pin.SE3(np.diag([1.0, 1.0, -1.0]), np.zeros(3))
        with pytest.raises(InputError):
            self.controller.switch(
                names, anchors={names[0]: pose((0.1, 0.0, 0.0)), names[1]: mirrored}
            )
        assert self.controller.supports.state() == before


@pytest.mark.parametrize("given", [{"speed": 0.0}, {"speed": "x"}, {"most": 0}, {"most": "x"}])
def test_settling_needs_a_speed_and_steps(given):
    with pytest.raises(InputError):
        InverseKinematics(ROBOT).settle(**given)


def require_same(state, before):
    """Two states of a controller hold the same numbers."""
    for name, values in before["workspace"].items():
        assert np.array_equal(values, state["workspace"][name], equal_nan=True), name
    assert state["supports"] == before["supports"]
    assert state["held"] == before["held"]
