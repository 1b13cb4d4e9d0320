"""A motion laid out in a workspace: levels of tasks with contacts, targets, pairs and fades."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeGuard, TypeVar

import numpy as np

from equipoise.compiled.workspace import Part, Shape, Workspace
from equipoise.contacts.program import ContactProgram
from equipoise.errors import InputError, NameNotFoundError
from equipoise.hqp import Block, Hierarchy
from equipoise.hqp.solvers.active_set.memory import (
    SEARCH_MEMORY,
    rows_shapes,
    search_shapes,
)
from equipoise.kinematics import Kinematics
from equipoise.kinematics.followers import moved_by
from equipoise.kinematics.kernels import state_of
from equipoise.motion.memory import (
    CLOCK_RATE,
    EASED,
    NEEDS_BEFORE,
    NEEDS_COM,
    NEEDS_MOTION,
    SEARCHES,
    SEARCHES_FROM,
    WEIGHED,
    task_shapes,
)
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import (
    AvoidanceTask,
    ComPolygonTask,
    ContactTask,
    FloorSupportTask,
    FramePoseTask,
    KernelTask,
    Task,
)
from equipoise.tasks.reach_memory import MISSED
from equipoise.tasks.view import COM_POINT, COM_POLYGON, FLOOR_SUPPORT, MOMENTUM
from equipoise.trajectories import Fade
from equipoise.trajectories.targets import TargetList, write_given

# the motion's parts of a workspace, in this order; the tree is part 0. Pairs and searches follow.
PARTS = ("reference", "targets", "contacts", "tasks", "rows")
FIRST = 1
LEAST_ROWS = 1

T_co = TypeVar("T_co", bound=Task, covariant=True)


@dataclass(frozen=True)
class Placed(Generic[T_co]):
    """A task in the hierarchy: its level, its rows, and what they are called."""

    task: T_co
    level: int
    rows: slice
    unit: str
    labels: tuple[str, ...]


class MotionProgram:
    """Levels of tasks, highest priority first, of which some fade (`fades[name of the task]`).

    Tasks in plain Python are asked once, at `kin`, for how many rows they have.
    Raises: `NameNotFoundError` for a fade of no task, `InputError` for two tasks of one name.
    """

    def __init__(
        self,
        robot: Robot,
        levels: Sequence[Sequence[Task]],
        fades: Mapping[str, Fade],
        kin: Kinematics,
        t: float,
    ) -> None:
        self.robot, self.fades = robot, dict(fades)
        self.levels = tuple(tuple(level) for level in levels)
        self.placed = _place(self.levels, kin, t)
        _require_names([one.task.name for one in self.placed], fades)
        self.kernel_tasks = [one for one in self.placed if _has_kernel(one)]
        self.avoidances = [one for one in self.placed if _avoids(one)]
        self.holding = [one for one in self.placed if _holds(one)]
        # those whose numbers lie in the part of the tasks, in the order that they have there
        self.numbered: list[Placed[KernelTask | AvoidanceTask]] = [
            *self.kernel_tasks,
            *self.avoidances,
        ]
        self.plain = [
            one
            for one in self.placed
            if not isinstance(one.task, KernelTask | AvoidanceTask | ContactTask)
        ]
        self.contacts = ContactProgram([c for one in self.holding for c in one.task.stack.contacts])
        self.targets = TargetList()
        for one in self.kernel_tasks:
            if one.task.target is not None:
                self.targets.number_of(one.task.target)
        self.frames = self._frames()

    @property
    def size(self) -> int:
        """Number of rows."""
        return max(self.placed[-1].rows.stop if self.placed else 0, LEAST_ROWS)

    @property
    def needs_python(self) -> bool:
        """Whether Python has to look at the state before the rows can be solved."""
        return bool(self.plain) or self.contacts.needs_python

    def _frames(self) -> list[int]:
        names = [frame for one in self.kernel_tasks for frame in one.task.frames]
        names += self.contacts.frames()
        return list(dict.fromkeys(map(self.robot.frame_id, names)))

    # -- laying out -----------------------------------------------------------------------------

    def shapes(self, frames: int) -> dict[str, list[tuple[str, Shape, bool]]]:
        """Return the arrays of the motion's parts, for a tree with a number of frames."""
        robot, nv = self.robot, self.robot.nv
        numbers = sum(len(one.task.numbers) for one in self.numbered)
        shapes = {
            "reference": state_of(robot.model, frames),
            "targets": self.targets.shapes(),
            "contacts": self.contacts.shapes(),
            "tasks": task_shapes(
                len(self.numbered),
                numbers,
                len(self.contacts.contacts),
                self.size,
                len(self.fades),
                nv,
            ),
            "rows": rows_shapes(self.size, nv, max(len(self.levels), 1)),
        }
        for k, one in enumerate(self.avoidances):
            shapes[f"pairs{k}"] = one.task.program.array_shapes()
        for k in range(len(self.fades) + 1):
            shapes[f"search{k}"] = search_shapes(self.size, nv, max(len(self.levels), 1))
        return shapes

    @property
    def memory(self) -> tuple[str, ...]:
        """What is kept from tick to tick."""
        searches = (
            f"search{k}.{name}" for k in range(len(self.fades) + 1) for name in SEARCH_MEMORY
        )
        live = ("targets.numbers",) if self.targets.live else ()
        lean = ("tasks.numbers",) if self.leans or self.waits else ()
        return ("reference.q", "tasks.v_ref", "tasks.clock", *searches, *live, *lean)

    @property
    def leans(self) -> bool:
        """Whether balance leans into what hands press: then numbers of tasks change.

        Only a robot that floats can tip over.
        """
        return self.robot.nv_base == 6 and any(
            isinstance(one.task, ComPolygonTask | FloorSupportTask) and one.task.leans
            for one in self.kernel_tasks
        )

    @property
    def waits(self) -> bool:
        """Whether a frame remembers that its target is out of reach."""
        return any(
            isinstance(one.task, FramePoseTask) and one.task.remembers for one in self.kernel_tasks
        )

    def missed(self, workspace: Workspace) -> dict[str, float]:
        """Return by name how far [m] the frames of tasks are from targets out of their reach."""
        part = workspace.parts["tasks"]
        found: dict[str, float] = {}
        for k, one in enumerate(self.kernel_tasks):
            if isinstance(one.task, FramePoseTask) and one.task.remembers:
                far = float(part.numbers[part.first[k] + MISSED])
                found |= {one.task.name: far} if far > 0.0 else {}
        return found

    def fill(self, workspace: Workspace, number_of: Callable[[str | int], int]) -> None:
        """Write the constants; `number_of` a frame is its number in the tree."""
        parts = workspace.parts
        self.targets.fill(parts["targets"])
        self.targets.lead(parts["targets"])
        self.contacts.fill(parts["contacts"], number_of)
        self._fill_tasks(workspace, number_of)
        self._fill_contacts(parts["tasks"])
        self._fill_rows(parts["rows"])
        for k, one in enumerate(self.avoidances):
            one.task.fill(parts[f"pairs{k}"])
        for k in range(len(self.fades) + 1):
            parts[f"search{k}"].counts[:] = 1

    def _fill_tasks(self, workspace: Workspace, number_of: Callable[[str | int], int]) -> None:
        part = workspace.parts["tasks"]
        part.kind[:] = 0
        first = 0
        for k, one in enumerate(self.numbered):
            task, numbers = one.task, one.task.numbers
            part.kind[k], part.at[k], part.first[k] = task.kind, one.rows.start, first
            part.numbers[first : first + len(numbers)] = numbers
            first += len(numbers)
            part.first[k + 1] = first
            if isinstance(task, KernelTask):
                part.rates[k] = task.rate
                part.frame[k] = 0 if task.frame is None else number_of(task.frame)
                if task.second is not None:
                    part.numbers[part.first[k]] = number_of(task.second)
                if task.target is not None:
                    part.target[k] = self.targets.number_of(task.target)
            else:
                which = k - len(self.kernel_tasks)
                part.pairs[k] = list(workspace.parts).index(f"pairs{which}")
        kinds = {one.task.kind for one in self.kernel_tasks}
        part.flags[NEEDS_COM] = bool(kinds & {COM_POINT, COM_POLYGON, FLOOR_SUPPORT, MOMENTUM})
        part.flags[NEEDS_BEFORE] = any(one.task.needs_before for one in self.kernel_tasks)
        part.flags[NEEDS_MOTION] = bool(kinds & {FLOOR_SUPPORT, MOMENTUM})
        part.clock[:] = 0.0
        part.clock[CLOCK_RATE] = 1.0
        part.flags[SEARCHES_FROM] = list(workspace.parts).index("search0")
        part.flags[SEARCHES] = len(self.fades) + 1
        part.row_weight[:], part.row_constant[:] = 1.0, 0
        for kernel in self.numbered:
            part.row_weight[kernel.rows] = kernel.task.weight
            part.row_constant[kernel.rows] = _is_constant(kernel.task)
        part.flags[WEIGHED] = bool((part.row_weight != 1.0).any())
        self._fill_ease(part)
        part.fade_of[:] = -1
        for f, (name, fade) in enumerate(self.fades.items()):
            part.fades[f] = fade.numbers
            for placed in self.placed:
                if placed.task.name == name:
                    part.fade_of[placed.rows] = f
        if not self.fades:
            part.fades[:] = Fade().numbers

    def _fill_ease(self, part: Part) -> None:
        part.row_ease[:], part.row_slope[:], part.row_cap[:] = np.inf, 0.0, np.inf
        for one in self.placed:
            task = one.task
            part.row_ease[one.rows], part.row_slope[one.rows] = task.ease, task.fastest_rate
            if task.row_caps is not None:
                part.row_cap[one.rows] = task.weight * task.row_caps
        part.flags[EASED] = bool(np.isfinite(part.row_ease).any())

    def _fill_contacts(self, part: Part) -> None:
        part.contact_held[:] = 1
        part.window[:] = np.inf, np.inf  # what there is none of never holds
        k = 0
        for one in self.holding:
            at = one.rows.start
            for contact in one.task.stack.contacts:
                part.window[k] = one.task.schedule.windows[contact.name]
                part.contact_at[k], part.contact_rate[k] = at, one.task.rate
                at, k = at + contact.size, k + 1

    def _fill_rows(self, part: Part) -> None:
        part.lower[:], part.upper[:] = -np.inf, np.inf
        part.first[:], part.last[:], part.single[:] = 0, self.robot.nv, -1
        ends, end = [], 0
        for level in range(len(self.levels)):
            end = max([end, *(one.rows.stop for one in self.placed if one.level == level)])
            ends.append(end)
        part.ends[:] = ends or [0]
        for one in self.kernel_tasks:
            one.task.write_constants(part.A[one.rows], self.robot)
            if one.task.constant_rows:
                part.A[one.rows] *= one.task.weight
            for row in range(one.rows.start, one.rows.stop):
                columns = np.flatnonzero(part.A[row])
                if len(columns) == 1:
                    part.single[row] = columns[0]
        self._mark_supports(part)

    def _mark_supports(self, part: Part) -> None:
        """Write first and last column of the rows that depend on one chain of joints only."""
        model = self.robot.model
        for one in self.kernel_tasks:
            carriers = [
                model.frames[self.robot.frame_id(frame)].parentJoint for frame in one.task.frames
            ]
            moving = [c for carrier in carriers for c in moved_by(model, carrier)]
            if moving:
                part.last[one.rows] = max(moving) + 1
        for row in np.flatnonzero(part.single >= 0):
            part.first[row], part.last[row] = part.single[row], part.single[row] + 1

    def let_go(self, workspace: Workspace, names: Collection[str]) -> None:
        """Leave the contacts of these names out of the reference, and hold all others."""
        held = workspace.parts["tasks"].contact_held
        for k, contact in enumerate(self.contacts.contacts):
            held[k] = contact.name not in names

    # -- what Python adds every tick ------------------------------------------------------------

    def write_before(self, workspace: Workspace, t: float) -> None:
        """Ask targets and surfaces in plain Python where they are at time `t` [s].

        Hand over what was set of live targets.
        """
        for live in self.targets.live:
            live.post()
        if self.targets.given:
            write_given(workspace.parts["targets"], self.targets.given, t)
        if self.contacts.placed:
            self.contacts.write_places(workspace.parts["contacts"], t)

    def write_plain(self, workspace: Workspace, kin: Kinematics, t: float) -> bool:
        """Write the rows of what is in plain Python; False if a task has other rows than before."""
        rows = workspace.parts["rows"]
        self.contacts.write_plain(
            workspace.parts["contacts"], kin, rows.A, workspace.parts["tasks"].contact_at.tolist()
        )
        for one in self.plain:
            asked = one.task.rows(kin, t)
            if asked.labels != one.labels:
                return False
            asked.check()
            w, own = one.task.weight, one.rows
            rows.A[own] = w * asked.A
            rows.lower[own], rows.upper[own] = w * asked.lower, w * asked.upper
        return True

    def ask_coal(self, workspace: Workspace) -> None:
        """Find out by Coal which distances the kernels left open."""
        for k, one in enumerate(self.avoidances):
            part = workspace.parts[f"pairs{k}"]
            if part.asked[0]:
                one.task.program.ask_coal(part)

    # -- the problem of the moment as an object ---------------------------------------------------

    def hierarchy(self, workspace: Workspace, weights: Array, least: float) -> Hierarchy:
        """Return the problem that stands in the workspace, without what counts less than `least`.

        Rows of contacts that do not hold are left out, and fading tasks of a weight below.
        """
        part, tasks = workspace.parts["rows"], workspace.parts["tasks"]
        blocks, ends, kept, end = [], [], [], 0
        for level in range(len(self.levels)):
            for one in (p for p in self.placed if p.level == level):
                f = int(tasks.fade_of[one.rows.start]) if one.rows.stop > one.rows.start else -1
                if f >= 0 and weights[f] < least:
                    continue
                rows, labels = self._counting(workspace, one)
                blocks.append(
                    Block(one.task.name, one.unit, labels, level, slice(end, end + len(rows)))
                )
                kept += rows
                end += len(rows)
            ends.append(end)
        A = part.A[kept].reshape(len(kept), self.robot.nv)
        lower, upper = part.lower[kept], part.upper[kept]
        A[np.isinf(lower) & np.isinf(upper)] = 0.0  # what a free row says is old
        return Hierarchy(A, lower, upper, tuple(ends), tuple(blocks))

    def _counting(
        self, workspace: Workspace, one: Placed[Task]
    ) -> tuple[list[int], tuple[str, ...]]:
        """Return the rows of a task that are there now, and their labels."""
        every = list(range(one.rows.start, one.rows.stop))
        if not isinstance(one.task, ContactTask):
            return every, one.labels
        held = workspace.parts["contacts"].on
        starts = workspace.parts["tasks"].contact_at
        rows = [
            row
            for k, contact in enumerate(self.contacts.contacts)
            if held[k]
            for row in range(starts[k], starts[k] + contact.size)
            if one.rows.start <= row < one.rows.stop
        ]
        return rows, tuple(one.labels[row - one.rows.start] for row in rows)


def _has_kernel(one: Placed[Task]) -> TypeGuard[Placed[KernelTask]]:
    return isinstance(one.task, KernelTask)


def _is_constant(task: Task) -> bool:
    return isinstance(task, KernelTask) and task.constant_rows


def _avoids(one: Placed[Task]) -> TypeGuard[Placed[AvoidanceTask]]:
    return isinstance(one.task, AvoidanceTask)


def _holds(one: Placed[Task]) -> TypeGuard[Placed[ContactTask]]:
    return isinstance(one.task, ContactTask)


def _place(levels: Sequence[Sequence[Task]], kin: Kinematics, t: float) -> tuple[Placed[Task], ...]:
    """Return the tasks with their rows, one after the other."""
    placed, start = [], 0
    for number, level in enumerate(levels):
        for task in level:
            if isinstance(task, KernelTask | AvoidanceTask):
                unit, labels = task.row_unit, task.row_labels
            elif isinstance(task, ContactTask):
                unit, labels = task.row_unit, task.labels
            else:
                asked = task.rows(kin, t)
                unit, labels = asked.unit, asked.labels
            placed.append(Placed(task, number, slice(start, start + len(labels)), unit, labels))
            start += len(labels)
    return tuple(placed)


def _require_names(names: Sequence[str], fades: Mapping[str, Fade]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError("two tasks share a name", given=twice, remedy="Rename one of them")
    for name in fades:
        if name not in names:
            raise NameNotFoundError("task", name, names)
