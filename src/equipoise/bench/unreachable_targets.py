"""Targets out of reach: the hands are sent away and called back, for the hard case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.bench.problem import Problem
from equipoise.robots.measures import measure
from equipoise.spatial import Array
from equipoise.tasks import FramePoseTask, Task
from equipoise.trajectories import PoseSample, PoseTrajectory

TOO_FAR = 0.5  # [m] beyond the reach of the arms
EVERY = 10  # ticks


@dataclass(frozen=True)
class ThrownTrajectory(PoseTrajectory):
    """A path that jumps by one of `jumps` (k, 3) [m] every `every` [s], one after the other."""

    path: PoseTrajectory
    jumps: Array
    every: float

    def at(self, t: float) -> PoseSample:
        """Return the pose that was jumped to, and the rate of the path."""
        sample = self.path.at(t)
        jump = self.jumps[int(t / self.every + 1e-9) % len(self.jumps)]
        T = sample.T_world_target
        return PoseSample(pin.SE3(T.rotation, T.translation + jump), sample.twist_world)


def throw_hands(problem: Problem, hands: Sequence[str]) -> tuple[tuple[Task, ...], ...]:
    """Return the levels with the hands' targets half a metre out of reach, ten ticks each."""
    tasks = problem.frame_tasks()
    middle = np.mean([tasks[h].target.at(0.0).T_world_target.translation for h in hands], axis=0)
    jumps, every = _jumps(problem, middle), EVERY * problem.dt

    def changed(task: Task) -> Task:
        if task.name not in hands or not isinstance(task, FramePoseTask):
            return task
        target = ThrownTrajectory(task.target, jumps, every)
        return FramePoseTask(task.name, task.frame, target, rate=task.rate)

    return tuple(tuple(changed(task) for task in level) for level in problem.levels)


def _jumps(problem: Problem, middle: Array) -> Array:
    """Return the jumps (k, 3): ahead, up, down and to either side, beyond the stretched arms."""
    sizes = measure(problem.robot)
    directions = np.array([[1, 0, 0], [1, 1, 0], [1, 0, 1], [1, -1, 0], [1, 0, -1]], dtype=float)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    far = sizes.p_world_shoulders + (sizes.reach + TOO_FAR) * directions
    return far - middle
