"""Posture: every joint is drawn to a configuration; one equality row a joint, the last level."""

from __future__ import annotations

from equipoise.compiled import compiled
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import require_rate
from equipoise.tasks.joint_rows import JointTask
from equipoise.tasks.view import POSTURE, TaskView, joint_positions


@compiled
def posture_rows(task: TaskView) -> None:
    """Write `v_j = rate * (q_joints - q)_j` for each joint."""
    wanted, lower = task.numbers, task.lower
    q = joint_positions(task.state, wanted.shape[0])
    for i in range(wanted.shape[0]):
        lower[task.at + i] = task.rate * (wanted[i] - q[i])
        task.upper[task.at + i] = lower[task.at + i]


class PostureTask(JointTask):
    """Draw the joints to `q_joints` (na,) with `rate` [1/s]: `v_j = rate * (q_joints - q)_j`."""

    row_unit = "rad/s"
    kind = POSTURE
    constant_rows = True
    alone = staticmethod(alone_of("posture", posture_rows))

    def __init__(self, name: str, robot: Robot, q_joints: Array, *, rate: float = 1.0) -> None:
        super().__init__(name, robot)
        self.q_joints = real_vector(f"the target of task {name!r}", q_joints, robot.na)
        self.rate = require_rate(name, rate)

    @property
    def numbers(self) -> Array:
        """The wanted joint positions."""
        return self.q_joints

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return (na,) [rad]: how far it is to the posture."""
        return self.q_joints - kin.q[-len(self.q_joints) :]

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return tuple(
            RowDescription.both(f"the posture of {label}", "rad/s", self.rate)
            for label in block.labels
        )
