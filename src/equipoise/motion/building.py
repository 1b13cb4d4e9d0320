"""From tasks to a hierarchy: each task writes its rows where they belong, without a copy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.hqp import Hierarchy, Rows
from equipoise.hqp.hierarchy import Block
from equipoise.kinematics import Kinematics
from equipoise.tasks import CompiledTask, KernelTask, Task
from equipoise.tasks.program import TaskProgram


class HierarchyBuilder:
    """Builds the hierarchy of one set of levels, remembering which rows belong to which task."""

    def __init__(self, levels: Sequence[Sequence[Task]]) -> None:
        self.levels = tuple(tuple(level) for level in levels)
        self._tasks = [task for level in self.levels for task in level]
        self._plain = [
            (i, task) for i, task in enumerate(self._tasks) if not isinstance(task, CompiledTask)
        ]
        # the rows of a `KernelTask` never change in number
        self._compiled = [
            task
            for task in self._tasks
            if isinstance(task, CompiledTask) and not isinstance(task, KernelTask)
        ]
        self._program = TaskProgram([], [])
        self._fillers: list[tuple[CompiledTask, int]] = []
        self._labels: list[tuple[str, ...]] | None = None
        self._blocks: tuple[Block, ...] = ()
        self._ends: tuple[int, ...] = ()

    def at(self, kin: Kinematics, t: float) -> Hierarchy:
        """Return the hierarchy at the state of `kin` and time `t` [s], in memory of its own.

        Raises: `NonFiniteError`, `InputError` naming the row that is not sound.
        """
        plain = {i: task.rows(kin, t) for i, task in self._plain}
        labels = [rows.labels for rows in plain.values()]
        labels += [task.row_labels(t) for task in self._compiled]
        if labels != self._labels:
            self._labels = labels
            self._lay_out(plain, t)
        m = self._ends[-1] if self._ends else 0
        A, lower, upper = np.empty((m, kin.robot.nv)), np.empty(m), np.empty(m)
        if self._program.count:
            self._program.fill(kin, t, A, lower, upper)
        for task, at in self._fillers:
            task.fill(kin, t, A, lower, upper, at)
        for i, rows in plain.items():
            own = self._blocks[i].rows
            A[own], lower[own], upper[own] = rows.A, rows.lower, rows.upper
        return Hierarchy.of_sound(A, lower, upper, self._ends, self._blocks)

    def _lay_out(self, plain: dict[int, Rows], t: float) -> None:
        blocks, ends = [], []
        end = i = 0
        for number, level in enumerate(self.levels):
            for task in level:
                if i in plain:
                    labels, unit = plain[i].labels, plain[i].unit
                else:
                    labels, unit = task.row_labels(t), task.row_unit
                start, end = end, end + len(labels)
                blocks.append(Block(task.name, unit, labels, number, slice(start, end)))
                i += 1
            ends.append(end)
        self._blocks, self._ends = tuple(blocks), tuple(ends)
        starts = [(task, b.rows.start) for task, b in zip(self._tasks, blocks, strict=True)]
        by_kernel = [(task, at) for task, at in starts if isinstance(task, KernelTask)]
        self._program = TaskProgram([task for task, _ in by_kernel], [at for _, at in by_kernel])
        self._fillers = [(task, at) for task, at in starts if task in self._compiled]


def build_hierarchy(levels: Sequence[Sequence[Task]], kin: Kinematics, t: float) -> Hierarchy:
    """Return the hierarchy of all tasks' rows at one state and time: built, not yet solved."""
    return HierarchyBuilder(levels).at(kin, t)
