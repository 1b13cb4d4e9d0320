"""What the kernel of a task is given: where things are, its numbers, and where its rows go."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.compiled import inlined
from equipoise.compiled.workspace import Block
from equipoise.kinematics.tree import base_size

# kinds of tasks as kernels know them; the rows of a GIVEN one are written from Python
(GIVEN, FRAME_POSE, GAZE, COM_POLYGON, JOINT_LIMITS, POSTURE, AVOIDANCE, JOINT_ACCELERATIONS,
 FLOOR_SUPPORT) = range(9)  # fmt: skip


class TaskView(NamedTuple):
    """One task at one state.

    `frame`: number of its frame in the tree; `target` [18]: pose row and twist of its target;
    `rate` [1/s]; `numbers` are its other constants. Its rows go to A, lower, upper from row `at`
    on. Of A only the columns that can differ from zero are written.
    """

    tree: Block
    state: Block
    frame: int
    target: np.ndarray
    rate: float
    numbers: np.ndarray
    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    at: int


@inlined
def first_actuated(tree: Block) -> int:
    """Return the first joint that has a motor: after the base, where that moves."""
    return 2 if base_size(tree) > 0 else 1
