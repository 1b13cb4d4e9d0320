"""Tasks that fade in and out: the velocity goes over smoothly from a hierarchy to the next.

A weight on rows does nothing for strict priorities: an equality scaled is the same equality. What
is blended is the answer. With weights w_1 >= ... >= w_m of the fading tasks it is
`(1 - w_1) v(none) + (w_1 - w_2) v(first) + ... + w_m v(all)`, v(S) the optimum with the tasks of S
only. It depends continuously on the weights, and where they are 0 and 1 it is an optimum itself.
As the violation of a level is a convex function of v, each level is violated at most as much as the
same blend of the optima; levels above every fading task, where all optima agree, stay optimal.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.errors import NameNotFoundError
from equipoise.hqp import Hierarchy, HierarchySolver, Solution, Status
from equipoise.hqp.solution import describe
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.motion.building import HierarchyBuilder
from equipoise.motion.generator import MotionStep
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import Task
from equipoise.trajectories.fade import Fade

Levels = Sequence[Sequence[Task]]


class Part(NamedTuple):
    """One hierarchy of a blend: its share, the problem and its optimum."""

    share: float
    hierarchy: Hierarchy
    solution: Solution


class Fading:
    """Levels of tasks of which some come and go, by `fades[name of the task]`.

    Outside of ramps a tick costs one solution, on ramps one more for each different weight.
    """

    def __init__(
        self,
        levels: Levels,
        fades: Mapping[str, Fade],
        new_solver: Callable[[], HierarchySolver],
    ) -> None:
        self.levels = tuple(tuple(level) for level in levels)
        names = {task.name for level in self.levels for task in level}
        for name in fades:
            if name not in names:
                raise NameNotFoundError("task", name, names)
        self.fades = dict(fades)
        self._new_solver = new_solver
        self._solvers = [new_solver()]
        self._builders: dict[frozenset[str], HierarchyBuilder] = {}

    def weights(self, t: float) -> dict[str, float]:
        """Return how much each fading task counts at time `t` [s]."""
        return {name: fade.weight(t) for name, fade in self.fades.items()}

    def parts(self, kin: Kinematics, t: float) -> list[Part]:
        """Return the hierarchies of the blend at a state and a time: the fullest first."""
        weights = self.weights(t)
        between = sorted({w for w in weights.values() if 0.0 < w < 1.0})
        parts = []
        for i, (below, least) in enumerate(zip([0.0, *between], [*between, 1.0], strict=True)):
            counting = frozenset(n for n, weight in weights.items() if weight >= least)
            hierarchy = self._builder(counting).at(kin, t)
            parts.append(Part(least - below, hierarchy, self._solver(i).solve(hierarchy)))
        return parts

    def _builder(self, counting: frozenset[str]) -> HierarchyBuilder:
        """Return the builder of the hierarchy with these of the fading tasks."""
        if counting not in self._builders:
            self._builders[counting] = HierarchyBuilder(
                [
                    [task for task in level if task.name not in self.fades or task.name in counting]
                    for level in self.levels
                ]
            )
        return self._builders[counting]

    def solve(self, kin: Kinematics, t: float) -> tuple[Hierarchy, Solution]:
        """Return the blended velocity, and the hierarchy of what counts fully with its violation.

        A task on a ramp is not promised anything yet: its rows are only in `parts`.
        """
        parts = self.parts(kin, t)
        _, hierarchy, settled = parts[-1]
        if len(parts) == 1:
            return hierarchy, settled
        v = sum((part.share * part.solution.v for part in parts), np.zeros(hierarchy.n))
        answers = [part.solution for part in parts]
        status = next((s.status for s in answers if s.status is not Status.SOLVED), Status.SOLVED)
        if any(s.status is Status.FAILED for s in answers):
            v, status = np.full(hierarchy.n, np.nan), Status.FAILED
        work = sum(s.iterations for s in answers)
        return hierarchy, describe(hierarchy, v, status, settled.solver, work)

    def _solver(self, i: int) -> HierarchySolver:
        """Return the solver of the i-th part: each starts from its own last answer."""
        while len(self._solvers) <= i:
            self._solvers.append(self._new_solver())
        return self._solvers[i]


class FadingGenerator:
    """As `MotionGenerator`, for levels of which some tasks fade."""

    def __init__(self, robot: Robot, fading: Fading, dt: float, q_start: Array) -> None:
        self.robot = robot
        self.levels = fading.levels
        self.fading = fading
        self.dt = dt
        self._evaluator = KinematicsEvaluator(robot)
        self._q = np.array(q_start, dtype=float)
        self._v = np.zeros(robot.nv)

    def step(self, t: float) -> MotionStep:
        """Solve at time `t` [s], return the reference of this moment and move on by `dt`."""
        kin = self._evaluator.at(self._q, self._v, t)
        hierarchy, solution = self.fading.solve(kin, t)
        self._q = pin.integrate(self.robot.model, self._q, solution.v * self.dt)
        self._v = solution.v
        return MotionStep(t, kin.q, solution.v, kin, hierarchy, solution)
