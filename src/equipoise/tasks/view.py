"""What the kernel of a task is given: where things are, its numbers, and where its rows go."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.compiled import inlined
from equipoise.compiled.workspace import Block, vector
from equipoise.kinematics.kernels import VELOCITY, Q

# kinds of tasks as kernels know them; the rows of a GIVEN one are written from Python
GIVEN, FRAME_POSE, GAZE, COM_POLYGON, JOINT_LIMITS, POSTURE, AVOIDANCE = range(7)
FRAME_AXES, COM_POINT, COUPLING, DAMPING, KEEP_IN, KEEP_OUT, RELATIVE_FRAME = range(7, 14)
JOINT_ACCELERATIONS, FLOOR_SUPPORT, MOMENTUM, MANIPULABILITY = range(14, 18)


class TaskView(NamedTuple):
    """One task at one state.

    `frame`: number of its frame in the tree; `target` [18]: pose row and twist of its target;
    `live`: the numbers of a target that is set while it runs, empty for others and alone; `rate`
    [1/s]; `numbers` are its other constants. Its rows go to A, lower, upper from row `at` on. Of A
    only the columns that can differ from zero are written.
    """

    tree: Block
    state: Block
    frame: int
    target: np.ndarray
    live: np.ndarray
    rate: float
    numbers: np.ndarray
    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    at: int


@inlined
def joint_positions(state: Block, na: int) -> np.ndarray:
    """Return the coordinates [na] of the joints that have a motor: what follows the base."""
    q = vector(state, Q)
    return q[q.shape[0] - na :]


@inlined
def joint_speeds(state: Block, na: int) -> np.ndarray:
    """Return the speeds [na] of the joints that have a motor."""
    v = vector(state, VELOCITY)
    return v[v.shape[0] - na :]
