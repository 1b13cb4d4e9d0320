"""The hierarchy of tasks solved once a tick; its velocity integrates to the reference posture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.hqp import Hierarchy, HierarchySolver, Solution
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.motion.building import HierarchyBuilder
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import Task


class MotionStep(NamedTuple):
    """What one tick of motion generation gives.

    `q_ref` (nq,) and `v_ref` (nv,) belong to the same moment; `kin` is the kinematics there.
    """

    t: float
    q_ref: Array
    v_ref: Array
    kin: Kinematics
    hierarchy: Hierarchy
    solution: Solution


class MotionGenerator:
    """Levels of tasks, highest priority first, solved at the reference posture.

    Source: section III-C, eqs. (14)-(16). Differs from the print: contact rows belong into level 0
    (see `ContactTask`), so that the projection (16) is the identity.
    """

    def __init__(
        self,
        robot: Robot,
        levels: Sequence[Sequence[Task]],
        solver: HierarchySolver,
        dt: float,
        q_start: Array,
    ) -> None:
        self.robot = robot
        self.levels = tuple(tuple(level) for level in levels)
        self.solver = solver
        self.dt = dt
        self._builder = HierarchyBuilder(self.levels)
        self._evaluator = KinematicsEvaluator(robot)
        self._q = np.array(q_start, dtype=float)
        self._v = np.zeros(robot.nv)

    def step(self, t: float) -> MotionStep:
        """Solve at time `t` [s], return the reference of this moment and move on by `dt`."""
        kin = self._evaluator.at(self._q, self._v, t)
        hierarchy = self._builder.at(kin, t)
        solution = self.solver.solve(hierarchy)
        step = MotionStep(t, kin.q, solution.v, kin, hierarchy, solution)
        self._q = pin.integrate(self.robot.model, self._q, solution.v * self.dt)
        self._v = solution.v
        return step
