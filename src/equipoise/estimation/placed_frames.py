"""Some frames of a robot, placed by one call: where they are, and their rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.compiled.workspace import Workspace
from equipoise.estimation.kernels import rows_of_frames
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import state_of
from equipoise.kinematics.state import KinematicsMemory
from equipoise.kinematics.tree import fill_tree, tree_of
from equipoise.robots import Robot
from equipoise.spatial import Array


class PlacedFrames:
    """Places frames of a robot in memory of its own; `more` rows follow those of the frames.

    `J` (6 l + more, nv) holds the rows of the last configuration, in world axes: velocity of the
    origin, then angular velocity, of one frame after the other.
    """

    def __init__(
        self, robot: Robot, frames: Sequence[str | int], more: int = 0, *, rows: bool = False
    ) -> None:
        ids = [robot.frame_id(frame) for frame in frames]
        shapes = {"tree": tree_of(robot.model, ids), "state": state_of(robot.model, len(ids))}
        workspace = Workspace(shapes)
        fill_tree(workspace.tree, robot.model, ids)
        self._memory = KinematicsMemory(robot, workspace, 1)
        self._blocks = workspace.floats, workspace.integers, workspace.tables
        self._places: Array = workspace.state.frames
        self.J = np.zeros((6 * len(ids) + more if rows else 0, robot.nv))

    def at(self, q: Array) -> Array:
        """Return the frames at configuration `q` (nq,) as pose rows (l, 12); the next call too."""
        rows_of_frames(*self._blocks, q, self.J)
        self._memory.stamp += 1
        return self._places

    def kinematics(self, t: float) -> Kinematics:
        """Return the kinematics of the last configuration, at rest, at time `t` [s]."""
        return Kinematics(self._memory, t)
