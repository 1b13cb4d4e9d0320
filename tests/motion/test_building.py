"""The hierarchy written in place is the one stacked from each task's own rows."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.hqp import Hierarchy, Rows
from equipoise.kinematics import KinematicsEvaluator
from equipoise.motion.building import HierarchyBuilder
from equipoise.tasks import (
    ContactTask,
    FixedPose,
    FramePoseTask,
    JointLimitsTask,
    PostureTask,
    Task,
)
from helpers import sole_contacts


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


def test_rows_written_in_place_are_those_of_the_tasks(hrp2, rng):
    q = hrp2.q_half_sitting
    kin = KinematicsEvaluator(hrp2).at(q, 0.1 * rng.normal(size=hrp2.nv))
    palm = hrp2.frame_id("left_palm")
    levels = [
        [ContactTask("contacts", ContactStack(sole_contacts(hrp2, q)))],
        [SlowBase("slow"), JointLimitsTask("limits", hrp2)],
        [FramePoseTask("palm", palm, FixedPose(kin.placement(palm)))],
        [PostureTask("posture", hrp2, q[7:] + 0.1)],
    ]
    builder = HierarchyBuilder(levels)
    for t in (0.0, 0.3, 0.7, 0.2):
        built = builder.at(kin, t)
        stacked = Hierarchy.stack(
            [[task.rows(kin, t) for task in level] for level in levels], hrp2.nv
        )
        assert built.blocks == stacked.blocks
        assert built.ends == stacked.ends
        for name in ("A", "lower", "upper"):
            assert np.array_equal(getattr(built, name), getattr(stacked, name))


def test_a_hierarchy_keeps_its_numbers_when_the_next_is_built(hrp2, rng):
    evaluator = KinematicsEvaluator(hrp2)
    builder = HierarchyBuilder([[PostureTask("posture", hrp2, hrp2.q_half_sitting[7:])]])
    first = builder.at(evaluator.at(hrp2.q_half_sitting, np.zeros(hrp2.nv)), 0.0)
    before = first.lower.copy()
    q = hrp2.q_half_sitting.copy()
    q[7:] += 0.1
    builder.at(evaluator.at(q, np.zeros(hrp2.nv)), 0.0)
    assert np.array_equal(first.lower, before)
