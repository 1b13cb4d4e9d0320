"""Pose of a frame (feet, hands) follows a trajectory: six equality rows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, inlined
from equipoise.compiled.workspace import integers, matrix
from equipoise.errors import InputError
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import FRAMES, frame_rows
from equipoise.kinematics.tree import FRAME_JOINT
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.kernels import rotation_difference
from equipoise.spatial.numbers import not_negative, positive
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import AimedTask, require_frame, require_rate
from equipoise.tasks.joint_rows import write_joint_rows
from equipoise.tasks.view import FRAME_POSE, TaskView
from equipoise.trajectories import PoseTrajectory

SPEED, TURN, DAMPING, JOINTS = range(4)  # entries of the numbers
FREE = 0.02  # [m] from the target nothing is damped
FARTHEST = 0.5  # [m] beyond which a target does not damp more
LEVER = 0.2  # [m] a turn counts as much as a way of this length for each radian


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
        far = math.sqrt(
            (target[9] - T[9]) ** 2 + (target[10] - T[10]) ** 2 + (target[11] - T[11]) ** 2
        )
        bound_pull(task, far, math.sqrt(rx * rx + ry * ry + rz * rz))
    for i in range(at, at + 6):
        upper[i] = lower[i]


@compiled
def bound_pull(task: TaskView, far: float, angle: float) -> None:
    """Shorten the wanted twist to its bounds; write how the joints are damped while far off."""
    lower, at, numbers = task.lower, task.at, task.numbers
    shorten(lower, at, numbers[SPEED])
    shorten(lower, at + 3, numbers[TURN])
    if numbers[DAMPING] == 0.0:
        return
    beyond = max(far - FREE, 0.0) + max(LEVER * angle - FREE, 0.0)
    w = numbers[DAMPING] * min(beyond, FARTHEST)
    na = int(numbers[JOINTS])
    first = task.A.shape[1] - na
    for i in range(na):
        row = at + 6 + i
        task.A[row, first + i] = w
        task.lower[row] = 0.0 if w > 0.0 else -np.inf
        task.upper[row] = 0.0 if w > 0.0 else np.inf


@inlined
def shorten(x: np.ndarray, at: int, longest: float) -> None:
    """Shorten the three numbers x[at : at + 3] to a length, keeping their direction."""
    length = math.sqrt(x[at] ** 2 + x[at + 1] ** 2 + x[at + 2] ** 2)
    if length > longest:
        for i in range(at, at + 3):
            x[i] *= longest / length


class FramePoseTask(AimedTask):
    """Drive the pose of `frame` to a trajectory: `J v = twist_ref + rate * error`.

    Args: `target`, a trajectory, or a pose that may be set while it runs (see `AimedTask`);
    `rate` [1/s], the paper's alpha of task convergence. `speed` [m/s] and `turn` [rad/s] bound what
    is asked of the frame, in its direction, however far off the target is. `damping` asks the
    joints of the `robot` on the same level not to move, the more the farther off the target is:
    rows `w v_j = 0` with `w = damping * distance`, so that an arm which is stretched to its end
    does not swing between two ways of being stretched. Closer than 2 cm and 0.1 rad nothing is
    damped; while it is, levels below get nothing.
    Source of the damping: Sugihara 2011 (Levenberg-Marquardt, the error as its damping).
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
        speed: float = math.inf,
        turn: float = math.inf,
        damping: float = 0.0,
        robot: Robot | None = None,
    ) -> None:
        super().__init__(name, target)
        self.frame: str | int = require_frame(name, frame)
        self.rate = require_rate(name, rate)
        self.speed = _bound(f"the speed of task {name!r}", speed, "m/s")
        self.turn = _bound(f"the turn of task {name!r}", turn, "rad/s")
        self.damping = not_negative(f"the damping of task {name!r}", damping)
        if self.damping and robot is None:
            raise InputError(
                f"task {name!r} has a damping but no robot whose joints it damps",
                remedy="Give the robot: FramePoseTask(..., damping=1.0, robot=robot)",
            )
        self._joints = robot.joint_names if robot is not None and self.damping else ()

    labels = ("x", "y", "z", "rx", "ry", "rz")
    units = ("m", "m", "m", "rad", "rad", "rad")

    @property
    def numbers(self) -> Array:
        """Speed, turn, damping and the number of joints; nothing where nothing is bounded."""
        if np.isinf([self.speed, self.turn]).all() and not self.damping:
            return np.zeros(0)
        return np.array([self.speed, self.turn, self.damping, len(self._joints)])

    @property
    def row_labels(self) -> tuple[str, ...]:
        """The components of the error, and the joints that are damped."""
        return (*self.labels, *(f"damping {joint}" for joint in self._joints))

    def write_constants(self, A: Array, robot: Any) -> None:
        """Write where the velocities of the damped joints stand."""
        write_joint_rows(A[6:], robot)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return (6,): position [m] and rotation vector [rad] to the target, world axes."""
        T, wanted = kin.placement(self.frame), self.target.at(t).T_world_target
        turn = pin.log3(wanted.rotation @ T.rotation.T)
        return np.concatenate((wanted.translation - T.translation, turn))

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        rows = {label: row for label, row in zip(self.labels, self._rates(), strict=True)}
        damped = RowDescription.both(f"the damping of {self.name} while far off", "m/s")
        return tuple(rows.get(label, damped) for label in block.labels)

    def _rates(self) -> tuple[RowDescription, ...]:
        return tuple(RowDescription.both(self.name, f"{unit}/s", self.rate) for unit in self.units)


def _bound(name: str, value: float, unit: str) -> float:
    return value if isinstance(value, float) and value == math.inf else positive(name, value, unit)
