"""Joints that move together: a weighted sum of joint positions has a value, one row a sum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from equipoise.compiled import compiled
from equipoise.errors import InputError
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_number, real_vector
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask, require_rate
from equipoise.tasks.view import COUPLING, TaskView, joint_positions


@compiled
def coupling_rows(task: TaskView) -> None:
    """Write `sum c_j v_j = rate * (value - sum c_j q_j)`; see `JointCouplingTask.numbers`."""
    numbers, na = task.numbers, int(task.numbers[-1])
    q = joint_positions(task.state, na)
    for k in range(numbers.shape[0] // (na + 1)):
        start = k * (na + 1)
        left = numbers[start]
        for i in range(na):
            left -= numbers[start + 1 + i] * q[i]
        task.lower[task.at + k] = task.upper[task.at + k] = task.rate * left


class JointCouplingTask(KernelTask):
    """Keep weighted sums of joint positions: `sum c_j q_j = value`.

    `sums` are mappings from joints to their weights, such as `{"knee": 1.0, "ankle": 0.5}`;
    `values` [rad or m] are zero if left out. `rate` [1/s].
    Raises: `InputError`, `NameNotFoundError`.
    """

    row_unit = "rad/s"
    kind = COUPLING
    constant_rows = True
    alone = staticmethod(alone_of("coupling", coupling_rows))

    def __init__(
        self,
        name: str,
        robot: Robot,
        sums: Sequence[Mapping[str, float]],
        *,
        values: Sequence[float] | None = None,
        rate: float = 10.0,
    ) -> None:
        super().__init__(name)
        require_robot(f"the robot of task {name!r}", robot)
        listed = isinstance(sums, Sequence) and all(isinstance(one, Mapping) for one in sums)
        if not listed or not sums or not all(sums):
            raise InputError(
                f"task {name!r} needs sums of joints, each with a weight for every joint in it",
                given=sums,
                remedy='Give [{"first": 1.0, "second": -1.0}, ...]',
            )
        wanted = np.zeros(len(sums)) if values is None else values
        self.sums = tuple(dict(one) for one in sums)
        self.rate = require_rate(name, rate)
        self.weights = np.zeros((len(sums), robot.na))
        for row, one in zip(self.weights, self.sums, strict=True):
            for joint, weight in one.items():
                row[robot.joint_index(joint)] = real_number(f"the weight of {joint}", weight)
        self.values = real_vector(f"the values of task {name!r}", wanted, len(sums))

    @property
    def labels(self) -> tuple[str, ...]:
        """The joints of each sum."""
        return tuple("+".join(one) for one in self.sums)

    @property
    def units(self) -> tuple[str, ...]:
        """Radians (metres for prismatic joints)."""
        return ("rad",) * len(self.sums)

    @property
    def numbers(self) -> Array:
        """For each sum its value and the weights of all joints; then how many joints there are."""
        sums = np.column_stack((self.values, self.weights)).ravel()
        return np.append(sums, self.weights.shape[1])

    def write_constants(self, A: Array, robot: Any) -> None:
        """Write the weights."""
        A[:, robot.nv_base :] = self.weights

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return by how much each sum is short of its value (k,) [rad or m]."""
        return self.values - self.weights @ kin.q[-self.weights.shape[1] :]

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return tuple(
            RowDescription.both(
                f"the coupling of {label.replace('+', ' and ')}", "rad/s", self.rate
            )
            for label in block.labels
        )
