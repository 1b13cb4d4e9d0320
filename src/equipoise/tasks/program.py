"""Tasks with kernels of their own, filled by one call: what each is, and where its rows go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.compiled.compilation import entrance
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import KernelTask
from equipoise.tasks.com_polygon import com_rows
from equipoise.tasks.frame_pose import pose_task_rows
from equipoise.tasks.gaze import gaze_rows
from equipoise.tasks.joint_limits import limit_rows
from equipoise.tasks.posture import posture_rows
from equipoise.trajectories.poses import (
    AttachedTrajectory,
    FixedPose,
    PoseTrajectory,
    attached_row,
)

FRAME_POSE, GAZE, COM_POLYGON, JOINT_LIMITS, POSTURE = range(5)
KERNELS = {
    "frame_pose": FRAME_POSE,
    "gaze": GAZE,
    "com_polygon": COM_POLYGON,
    "joint_limits": JOINT_LIMITS,
    "posture": POSTURE,
}


class TaskProgram:
    """The rows of some tasks in a hierarchy; their numbers are gathered here once.

    Calling a kernel from Python costs more than most of these kernels, hence one call for all.
    """

    def __init__(self, tasks: Sequence[KernelTask], starts: Sequence[int]) -> None:
        self.count = len(tasks)
        self._kinds = np.array([KERNELS[task.kernel] for task in tasks], dtype=np.int64)
        self._frames = np.array([task.frame for task in tasks], dtype=np.int64)
        self._rates = np.array([task.rate for task in tasks], dtype=float)
        self._starts = np.array(starts, dtype=np.int64)
        parts = [np.asarray(task.numbers, dtype=float).ravel() for task in tasks]
        self._ends = np.cumsum([len(part) for part in parts], dtype=np.int64)
        self._numbers = np.concatenate([*parts, np.zeros(0)])
        self._targets = np.zeros((len(tasks), 18))
        self._attached = np.zeros((len(tasks), 12))
        self._body_of = np.full(len(tasks), -1, dtype=np.int64)
        self._moving: list[tuple[Array, PoseTrajectory]] = []
        self._take_targets([task.target for task in tasks])
        self._needs_com = any(kind == COM_POLYGON for kind in self._kinds)

    def _take_targets(self, targets: Sequence[PoseTrajectory | None]) -> None:
        """Note what moves; what is attached to it is left to the kernel, what rests is done."""
        bodies: dict[int, int] = {}
        moving: list[PoseTrajectory] = []
        for i, target in enumerate(targets):
            if isinstance(target, FixedPose):
                self._targets[i] = target.row(0.0)
            elif isinstance(target, AttachedTrajectory):
                self._attached[i] = target.attached
                self._body_of[i] = bodies.setdefault(id(target.body), len(moving))
                if self._body_of[i] == len(moving):
                    moving.append(target.body)
            elif target is not None:
                self._moving.append((self._targets[i], target))
        self._bodies = np.zeros((len(moving), 18))
        self._moving += zip(self._bodies, moving, strict=True)

    def fill(self, kin: Kinematics, t: float, A: Array, lower: Array, upper: Array) -> None:
        """Write all rows at the state of `kin` and time `t` [s]."""
        live = kin.live_with_com if self._needs_com else kin.live
        for row, target in self._moving:
            row[:] = target.row(t)
        fill_tasks(
            self._kinds,
            self._frames,
            self._rates,
            self._starts,
            self._ends,
            self._numbers,
            self._targets,
            self._bodies,
            self._body_of,
            self._attached,
            live.q,
            live.joint_ids,
            live.columns,
            live.carries,
            live.frames,
            live.com,
            live.com_rows,
            A,
            lower,
            upper,
        )


@entrance
def fill_tasks(
    kinds: np.ndarray,
    frame_ids: np.ndarray,
    rates: np.ndarray,
    starts: np.ndarray,
    ends: np.ndarray,
    numbers: np.ndarray,
    targets: np.ndarray,
    bodies: np.ndarray,
    body_of: np.ndarray,
    attached: np.ndarray,
    q: np.ndarray,
    joint_ids: np.ndarray,
    columns: np.ndarray,
    carries: np.ndarray,
    frames: np.ndarray,
    com: np.ndarray,
    J_com: np.ndarray,
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> None:
    """Write the rows of each task i from row starts[i] on; its numbers end at ends[i].

    Its target is targets[i], or what is attached to the body body_of[i] if that is not negative.
    """
    first = 0
    for i in range(kinds.shape[0]):
        own, rate, at = numbers[first : ends[i]], rates[i], starts[i]
        first = ends[i]
        if body_of[i] >= 0:
            attached_row(bodies[body_of[i]], attached[i], targets[i])
        T, carried = frames[frame_ids[i]], carries[joint_ids[frame_ids[i]]]
        if kinds[i] == FRAME_POSE:
            pose_task_rows(columns, carried, T, targets[i], rate, A, lower, upper, at)
        elif kinds[i] == GAZE:
            gaze_rows(columns, carried, T, targets[i], rate, A, lower, upper, at)
        elif kinds[i] == COM_POLYGON:
            com_rows(com, J_com, own, rate, A, lower, upper, at)
        elif kinds[i] == JOINT_LIMITS:
            limit_rows(q, own, rate, A, lower, upper, at)
        else:
            posture_rows(q, own, rate, A, lower, upper, at)
