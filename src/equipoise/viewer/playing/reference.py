"""A session that moves the reference only: contacts, limits, balance; no torque law, no engine."""

from __future__ import annotations

import numpy as np

from equipoise.motion import InverseKinematics
from equipoise.motion.generator import MotionStep
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import Task
from equipoise.viewer.playing.lead import Pace
from equipoise.viewer.playing.reason import Solved
from equipoise.viewer.playing.session import ACCELERATIONS, PlaySession

PERIOD = 0.01  # [s] of a step


class ReferenceSession(PlaySession):
    """Moves a robot by the hierarchy alone. Raises: InputError where nothing can be dragged."""

    def __init__(self, robot: Robot) -> None:
        self._step: MotionStep | None = None
        super().__init__(robot, Pace())

    def run(self, seconds: float) -> Array:
        """Go on for some time, at least a step; return the configuration (nq,)."""
        with self._lock:
            for _ in range(max(1, round(seconds / PERIOD))):
                self._lead(PERIOD)
                self._step = self._ik.step()
                self.q = np.array(self._ik.motion.q_ref)
            return self.q

    def _reference(self) -> Array:
        return self.q

    def _take(self, levels: list[list[Task]]) -> None:
        self._ik = InverseKinematics(
            self.robot,
            levels,
            self.q,
            period=PERIOD,
            feet=feet_names(self.robot),
            accelerations=ACCELERATIONS,
        )
        self._step = None

    def _solved(self) -> Solved | None:
        if self._step is None:
            return None
        return Solved(self._ik.motion.levels, self._step.hierarchy, self._step.solution.v)


def feet_names(robot: Robot) -> tuple[str, ...] | None:
    """Return the frames of feet that are points; None where it has soles, or is fixed."""
    if robot.soles or not robot.nv_base:
        return None
    return tuple(foot.frame for foot in robot.feet)
