"""The rows of the contacts that hold, at a measured state: Jacobian, drift, rate, residual."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.compiled import entrance
from equipoise.compiled.workspace import Workspace, part_of
from equipoise.contacts import ContactStack
from equipoise.contacts.program import (
    ContactProgram,
    contact_drifts,
    contact_rows,
    move_surfaces,
)
from equipoise.kinematics.kernels import (
    WITH_FRAMES,
    WITH_MOTION,
    evaluate,
    evaluate_more,
    state_of,
)
from equipoise.kinematics.state import Kinematics, KinematicsMemory
from equipoise.kinematics.tree import fill_tree, tree_of
from equipoise.robots import Robot
from equipoise.spatial import Array

STATE = 1  # number of the part that holds the measured state


class Rows(NamedTuple):
    """`J` (r, nv), and `drift`, `rate`, `residual` (r,) of the stacked contacts.

    The second derivative of the residual is `J dv/dt + drift`; `J v = rate` while they hold.
    """

    J: Array
    drift: Array
    rate: Array
    residual: Array


@entrance
def rows_alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, J: np.ndarray, at: np.ndarray,
    t: float,
) -> None:  # fmt: skip
    """Write rows and drifts of all contacts at the state that was evaluated last."""
    tree, state, contacts = (
        part_of(floats, whole, tables, 0),
        part_of(floats, whole, tables, 1),
        part_of(floats, whole, tables, 2),
    )
    move_surfaces(contacts, t)
    contact_rows(tree, state, contacts, J, at)
    contact_drifts(tree, state, contacts, J)


class ContactGeometry:
    """Evaluates the contacts of one stack; `at` returns views that its next call overwrites."""

    def __init__(self, robot: Robot, contacts: ContactStack) -> None:
        program = ContactProgram(contacts.contacts)
        frames = list(dict.fromkeys(map(robot.frame_id, program.frames())))
        model = robot.model
        self._workspace = Workspace(
            {
                "tree": tree_of(model, frames),
                "state": state_of(model, len(frames)),
                "contacts": program.shapes(),
            }
        )
        fill_tree(self._workspace.tree, model, frames)
        self._program, self._part = program, self._workspace.parts["contacts"]
        program.fill(self._part, lambda frame: frames.index(robot.frame_id(frame)))
        workspace = self._workspace
        self._blocks = workspace.floats, workspace.integers, workspace.tables
        self._memory = KinematicsMemory(robot, workspace, STATE)
        self._at = np.array(program.starts[:-1] or [0], dtype=np.int64)
        self._J = np.zeros((max(contacts.size, 1), robot.nv))
        self._size = contacts.size

    def at(self, q: Array, v: Array, t: float) -> Rows:
        """Return the rows at a finite state `q` (nq,), `v` (nv,) and time `t` [s]."""
        program, part, size = self._program, self._part, self._size
        evaluate(*self._blocks, STATE, q, v)
        evaluate_more(*self._blocks, STATE, WITH_FRAMES | WITH_MOTION)
        self._memory.stamp += 1
        program.write_places(part, t)
        if program.needs_python:
            kin = Kinematics(self._memory, t)
            program.write_plain(part, kin, self._J, self._at)
            program.write_plain_drifts(part, kin)
        rows_alone(*self._blocks, self._J, self._at, t)
        return Rows(self._J[:size], part.drift[:size], part.rate[:size], part.residual[:size])
