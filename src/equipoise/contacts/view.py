"""What the kernel of a contact is given: where things are, its numbers, and where its rows go."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.compiled import inlined
from equipoise.compiled.workspace import Block, integers, matrix
from equipoise.kinematics.kernels import FRAMES
from equipoise.kinematics.tree import FRAME_JOINT

# kinds of contacts as kernels know them; the rows of a GIVEN one are written from Python
GIVEN, SOLE, GRASP, POINT, SLIDING = range(5)
NUMBERS = 24  # numbers of a contact at most


class ContactView(NamedTuple):
    """One contact at one state.

    `first`, `second`: numbers of its frames in the tree (the same twice where it has one).
    `numbers` [24] are its constants. `place` [24] is where a surface is and how it moves (pose row,
    twist, time derivative of that), `sample` [13] value, gradient and Hessian of it at the contact
    point. The rows go to `J` [r, nv] from row `at` on, `residual`, `rate` and `drift` to theirs
    from `own` on. Of J only the columns that move the contact are written.
    """

    tree: Block
    state: Block
    first: int
    second: int
    numbers: np.ndarray
    place: np.ndarray
    sample: np.ndarray
    surface: int
    J: np.ndarray
    at: int
    residual: np.ndarray
    rate: np.ndarray
    drift: np.ndarray
    own: int


@inlined
def frame_of(tree: Block, state: Block, number: int) -> np.ndarray:
    """Return the pose row of a frame of the tree."""
    return matrix(state, FRAMES)[number]


@inlined
def joint_of(tree: Block, number: int) -> int:
    """Return the joint that carries a frame of the tree."""
    return integers(tree, FRAME_JOINT)[number]
