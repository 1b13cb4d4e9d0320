"""Weights inside a level: what they share out, in kernels and in Python, and what explain says."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise import InverseKinematics, read_scenario
from equipoise.errors import InputError
from equipoise.hqp import explain, load_problem, save_problem
from equipoise.hqp.solvers import make_solver
from equipoise.motion import MotionGenerator
from equipoise.simulation.build.levels import build_levels
from equipoise.simulation.build.setup import build_setup
from equipoise.spatial import pose
from equipoise.tasks import ContactTask, FrameAxesTask, Task, describe_rows

RATE = 10.0
EVERYDAY = {
    "axes": "{kind: frame_axes, frame: left_palm, priority: 3, axes: [x, z], "
    "waypoints: [{t: 0.0, xyz: [0.3, 0.3, 0.9]}]}",
    "seen": "{kind: relative_frame, frame: right_palm, relative_to: BODY, priority: 3, "
    "waypoints: [{t: 0.0, xyz: [0.3, -0.3, 0.2]}]}",
    "com_at": "{kind: com_point, priority: 3, waypoints: [{t: 0.0, xyz: [0.0, 0.0, 0.7]}]}",
    "knees": "{kind: joint_coupling, priority: 3, joints: {LLEG_JOINT3: 1.0, RLEG_JOINT3: -1.0}}",
    "still": "{kind: damping, priority: 5}",
    "room": "{kind: keep_in, frame: left_palm, priority: 3, at: {xyz: [0.3, 0.3, 0.9]}, "
    "size: [0.6, 0.6, 0.6]}",
    "ball": "{kind: keep_out, frame: left_palm, priority: 3, at: {xyz: [0.3, 0.0, 1.6]}, "
    "radius: 0.2}",
    "brake": "{kind: joint_accelerations, priority: 3}",
    "support": "{kind: floor_support, priority: 3}",
    "far": "{kind: frame_path, frame: right_palm, priority: 3, damping: 1.0, pull: 0.4, "
    "waypoints: [{t: 0.0, xyz: [0.7, -0.3, 1.0]}]}",
}


class Plain(Task):
    """A task in plain Python with the rows of another one."""

    def __init__(self, like: Task) -> None:
        super().__init__(like.name)
        self.like, self.labels, self.units = like, like.labels, like.units

    labels = units = ()

    def rows(self, kin, t):
        return self.like.rows(kin, t)

    def error(self, kin, t):
        return self.like.error(kin, t)


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("weights", [(1.0, 1.0), (3.0, 1.0), (0.5, 2.0)])
def test_two_that_want_one_height_share_it_by_squares(hrp2, weights, plain) -> None:
    """The rate is the mean of both wishes, each with the square of its weight: a closed form."""
    T = hrp2.at(hrp2.q_half_sitting).placement("left_palm")
    wishes = 0.04, -0.02
    tasks: list[Task] = []
    for name, wish, weight in zip("ab", wishes, weights, strict=True):
        there = pose((0.0, 0.0, wish)) * T
        task: Task = FrameAxesTask(name, "left_palm", there, axes=("z",), rate=RATE)
        height = T.rotation[2, 2]
        assert abs(height) < 0.9  # axes of the target: z of the palm does not point up
        tasks.append((Plain(task) if plain else task).weighing(weight))
    lifts = [float((T.rotation.T @ [0.0, 0.0, wish])[2]) for wish in wishes]
    step = InverseKinematics(hrp2, [tasks]).step()
    J = step.kin.jacobian("left_palm")[:3]
    w = np.square(weights)
    wanted = RATE * (w @ lifts) / w.sum()
    assert (T.rotation.T @ J @ step.v_ref)[2] == pytest.approx(wanted, abs=1e-6)


def levels_of(weight: float):
    overrides = [f"tasks.{name}={spec}" for name, spec in EVERYDAY.items()]
    scenario = read_scenario("tray", overrides)
    overrides += [f"tasks.{name}.weight={weight}" for name in scenario.tasks]
    scenario = read_scenario("tray", overrides)
    setup = build_setup(scenario)
    return setup.robot, build_levels(scenario, setup), scenario.control.period


def test_every_kind_is_scaled_and_one_weight_for_all_changes_nothing() -> None:
    """Hierarchies of several ticks: rows times the weight, the same answer, row for row."""
    found = []
    for weight in (1.0, 2.5):
        robot, levels, period = levels_of(weight)
        motion = MotionGenerator(
            robot, levels, lambda: make_solver("active_set"), period, robot.q_half_sitting
        )
        steps = [motion.step(0.001 * k) for k in range(2)]
        step = motion.step(0.002)
        found.append((step.hierarchy, step.v_ref, steps))
    (plain, v, _), (scaled, v_scaled, _) = found
    assert v_scaled == pytest.approx(v, abs=1e-6)
    assert {b.name for b in plain.blocks} >= set(EVERYDAY)
    for block in plain.blocks:
        rows, w = block.rows, 1.0 if block.name == "contacts" else 2.5
        bounded = np.isfinite(plain.lower[rows]) | np.isfinite(plain.upper[rows])
        size = 1e-5 * max(1.0, np.abs(plain.A[rows]).max(initial=0.0))
        assert scaled.A[rows][bounded] == pytest.approx(w * plain.A[rows][bounded], abs=size)
        for side in ("lower", "upper"):
            one, other = getattr(plain, side)[rows], getattr(scaled, side)[rows]
            assert other[bounded] == pytest.approx(w * one[bounded], rel=1e-4, abs=1e-4)


def test_what_explain_says_is_in_metres_whatever_the_weight(hrp2, tmp_path) -> None:
    """Two wishes of one frame, 2 cm apart: weights share the gap out, the words keep its unit."""
    T = hrp2.at(hrp2.q_half_sitting).placement("left_palm")
    a = FrameAxesTask("a", "left_palm", pose((0.02, 0.0, 0.0)) * T, axes=("x", "y", "z"))
    b = FrameAxesTask("b", "left_palm", T, axes=("x", "y", "z"))
    step = InverseKinematics(hrp2, [[a.weighing(2.0), b]]).step()
    words = describe_rows([a, b], step.hierarchy)
    save_problem(tmp_path / "kept.npz", step.hierarchy, words=words)
    assert load_problem(tmp_path / "kept.npz").words == words
    said = explain(step.hierarchy, step.v_ref, words)
    assert said.of("a").amounts[0][0] == pytest.approx(0.02 * 1 / 5, rel=1e-3)
    assert said.of("b").amounts[0][0] == pytest.approx(0.02 * 4 / 5, rel=1e-3)


def test_weights_that_make_no_sense_are_refused(hrp2) -> None:
    T = hrp2.at(hrp2.q_half_sitting).placement("left_palm")
    task = FrameAxesTask("a", "left_palm", T)
    for weight in (0.0, -1.0, 1e4, float("nan")):
        with pytest.raises(InputError, match="weight of task 'a'"):
            task.weighing(weight)
    _, levels, _ = levels_of(1.0)
    contacts = next(t for level in levels for t in level if isinstance(t, ContactTask))
    with pytest.raises(InputError, match="contacts hold or do not"):
        contacts.weighing(2.0)
