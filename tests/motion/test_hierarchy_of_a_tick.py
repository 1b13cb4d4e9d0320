"""The hierarchy written in place is the one stacked from each task's own rows."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.contacts import ContactStack
from equipoise.hqp import Hierarchy, Rows, make_solver
from equipoise.motion import MotionGenerator, StaleMotionError
from equipoise.tasks import ContactTask, FramePoseTask, JointLimitsTask, PostureTask, Task
from equipoise.trajectories import FixedPose
from helpers import sole_contacts

DT = 1e-3


class SlowBase(Task):
    """A task of a user's own, in plain Python: its rows come and go."""

    labels, units = ("vx",), ("m",)

    def rows(self, kin, t):
        A = np.zeros((2 if t > 0.5 else 1, kin.robot.nv))
        A[:, 0] = 1.0
        labels = ("vx", "again")[: len(A)]
        return Rows(self.name, "m/s", labels, A, np.full(len(A), -0.1), np.full(len(A), t))

    def error(self, kin, t):
        return np.zeros(1)


def levels_of(robot):
    q = robot.q_half_sitting
    return [
        [ContactTask("contacts", ContactStack(sole_contacts(robot, q)))],
        [SlowBase("slow"), JointLimitsTask("limits", robot)],
        [FramePoseTask("palm", "left_palm", FixedPose(robot.at(q).placement("left_palm")))],
        [PostureTask("posture", robot, q[7:] + 0.1)],
    ]


@pytest.mark.parametrize("solver", ["active_set", "cascade"])
def test_rows_written_in_place_are_those_of_the_tasks(hrp2, rng, solver):
    """Also when a task in plain Python has more rows than before, and then fewer."""
    levels, v = levels_of(hrp2), 0.1 * rng.normal(size=hrp2.nv)
    motion = MotionGenerator(hrp2, levels, make_solver(solver), DT, hrp2.q_half_sitting)
    for t in (0.0, 0.3, 0.7, 0.8, 0.2):
        motion.reset(motion.q_ref, v)
        step = motion.step(t)
        built, solution = step.hierarchy, step.solution
        kin = hrp2.at(step.q_ref, v, t)
        stacked = Hierarchy.stack(
            [[task.rows(kin, t) for task in level] for level in levels], hrp2.nv
        )
        assert built.blocks == stacked.blocks
        assert built.ends == stacked.ends
        for name in ("A", "lower", "upper"):
            assert np.allclose(getattr(built, name), getattr(stacked, name), atol=1e-13)
        assert solution.certificate(stacked).holds()
        slack = np.empty(len(levels))
        motion.measure_levels(slack)
        assert np.allclose(slack, solution.slack, atol=1e-12)


def test_a_hierarchy_keeps_its_numbers_when_the_next_is_built(hrp2):
    levels = [[PostureTask("posture", hrp2, hrp2.q_half_sitting[7:] + 0.1)]]
    motion = MotionGenerator(hrp2, levels, make_solver("active_set"), DT, hrp2.q_half_sitting)
    first = motion.step(0.0).hierarchy
    before = first.lower.copy()
    motion.step(DT)
    assert np.array_equal(first.lower, before)


def test_a_tick_that_is_gone_is_not_answered_for(hrp2):
    motion = MotionGenerator(
        hrp2, levels_of(hrp2), make_solver("active_set"), DT, hrp2.q_half_sitting
    )
    first, asked = motion.step(0.0), motion.step(DT)
    with pytest.raises(StaleMotionError, match="before the next step"):
        _ = first.solution
    known = asked.solution
    motion.step(2 * DT)
    assert asked.solution is known  # what was put together stays
