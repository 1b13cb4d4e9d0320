"""Pose of a frame (feet, hands) follows a trajectory: six equality rows."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled
from equipoise.compiled.workspace import integers, matrix
from equipoise.given import require_kind
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import FRAMES, frame_rows
from equipoise.kinematics.tree import FRAME_JOINT
from equipoise.spatial import Array
from equipoise.spatial.kernels import rotation_difference
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import AimedTask, require_frame, require_rate
from equipoise.tasks.joint_rows import write_joint_rows
from equipoise.tasks.reach import Reach, bound_reach
from equipoise.tasks.view import FRAME_POSE, TaskView
from equipoise.trajectories import PoseTrajectory


@compiled
def frame_pose_rows(task: TaskView) -> None:
    """Write `J v = twist_ref + rate * error` of a frame."""
    T, target, rate = matrix(task.state, FRAMES)[task.frame], task.target, task.rate
    joint = integers(task.tree, FRAME_JOINT)[task.frame]
    lower, upper, at = task.lower, task.upper, task.at
    frame_rows(task.tree, task.state, joint, T, task.A, at)
    rx, ry, rz = rotation_difference(target, T)
    for i in range(3):
        lower[at + i] = target[12 + i] + rate * (target[9 + i] - T[9 + i])
    lower[at + 3] = target[15] + rate * rx
    lower[at + 4] = target[16] + rate * ry
    lower[at + 5] = target[17] + rate * rz
    if task.numbers.shape[0]:
        x, y, z = target[9] - T[9], target[10] - T[10], target[11] - T[11]
        bound_reach(task, (x, y, z, rx, ry, rz))
    for i in range(at, at + 6):
        upper[i] = lower[i]


class FramePoseTask(AimedTask):
    """Drive the pose of `frame` to a trajectory: `J v = twist_ref + rate * error`.

    Args: `target`, a trajectory, or a pose that may be set while it runs (see `AimedTask`);
    `rate` [1/s], the paper's alpha of task convergence. `reach` says how a target is gone for that
    the frame is behind, or that lies out of its reach (see `Reach`); without one it is exact, but
    the doors of `WholeBodyController` give a hand whose target is set while it runs a reach of
    their own; False: it is always exact.
    Source: eqs. (9)-(10). Differs from the print: the sign of (10) is that of J, the Jacobian of
    the frame itself and not of the error; the target's own twist is fed forward.
    """

    row_unit = "m/s, rad/s"
    kind = FRAME_POSE
    alone = staticmethod(alone_of("frame_pose", frame_pose_rows))

    def __init__(
        self,
        name: str,
        frame: str | int,
        target: PoseTrajectory | pin.SE3,
        *,
        rate: float = 10.0,
        reach: Reach | Literal[False] | None = None,
    ) -> None:
        super().__init__(name, target)
        self.frame: str | int = require_frame(name, frame)
        self.rate = require_rate(name, rate)
        if reach is not None and reach is not False:
            require_kind(f"the reach of task {name!r}", reach, Reach)
        self.reach: Reach | None = reach or None
        self._chosen = reach is not None

    def wait_where_out_of_reach(self, reach: Reach) -> None:
        """Take a reach, unless one was chosen at the construction; before its rows are laid out."""
        if not self._chosen:
            require_kind(f"the reach of task {self.name!r}", reach, Reach)
            self.reach = reach

    @property
    def remembers(self) -> bool:
        """Whether its numbers change: it knows for how long its target has been out of reach."""
        return self.reach is not None and self.reach.span is not None

    @property
    def chosen(self) -> bool:
        """Whether its maker said how it goes for what is out of reach."""
        return self._chosen

    labels = ("x", "y", "z", "rx", "ry", "rz")
    units = ("m", "m", "m", "rad", "rad", "rad")

    @property
    def numbers(self) -> Array:
        """Those of the reach; none without one."""
        return np.zeros(0) if self.reach is None else self.reach.numbers

    @property
    def needs_before(self) -> bool:
        """Whether its rows depend on the velocity of the tick before."""
        return self.reach is not None

    @property
    def row_labels(self) -> tuple[str, ...]:
        """The components of the error, and the joints that a reach keeps calm."""
        joints = () if self.reach is None else self.reach.robot.joint_names
        return (*self.labels, *(f"calm {joint}" for joint in joints))

    def write_constants(self, A: Array, robot: Any) -> None:
        """Write where the velocities of the joints stand that a reach keeps calm."""
        write_joint_rows(A[6:], robot)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return (6,): position [m] and rotation vector [rad] to the target, world axes."""
        T, wanted = kin.placement(self.frame), self.target.at(t).T_world_target
        turn = pin.log3(wanted.rotation @ T.rotation.T)
        return np.concatenate((wanted.translation - T.translation, turn))

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        rows = {label: row for label, row in zip(self.labels, self._rates(), strict=True)}
        calm = RowDescription.both(f"the calm of the joints while {self.name} is behind", "m/s")
        return tuple(rows.get(label, calm) for label in block.labels)

    def _rates(self) -> tuple[RowDescription, ...]:
        return tuple(RowDescription.both(self.name, f"{unit}/s", self.rate) for unit in self.units)
