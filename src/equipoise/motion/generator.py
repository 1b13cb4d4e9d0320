"""The hierarchy of tasks solved once a tick; its velocity integrates to the reference posture."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from equipoise.collision.pairs import FIND
from equipoise.compiled import entrance
from equipoise.compiled.workspace import Workspace, part_of
from equipoise.errors import AdviceWarning, EquipoiseError
from equipoise.hqp import Hierarchy, HierarchySolver, Solution, Status
from equipoise.hqp.solution import describe
from equipoise.hqp.solvers.active_set.memory import FAILED, ITERATION_LIMIT, SOLVED, WORKS
from equipoise.hqp.solvers.active_set.solve import SOLVE as SOLVER
from equipoise.hqp.solvers.active_set.solver import ActiveSet
from equipoise.kinematics import Kinematics
from equipoise.kinematics.state import KinematicsMemory
from equipoise.kinematics.tree import fill_tree, tree_of
from equipoise.motion.kernels import (
    MotionBlocks,
    measure_levels,
    motion_begin,
    move_on,
    solve_motion,
    write_rows,
)
from equipoise.motion.memory import STATUS, TICK, USED
from equipoise.motion.program import FIRST, MotionProgram
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector, require_period, time_of
from equipoise.tasks import Task
from equipoise.tasks.base import require_rates
from equipoise.trajectories import Fade

# parts of a tick: between them stands what Python has to see or to find out
STAGES = (SOLVER, FIND)  # kernels that a motion calls by address
BEGIN, ROWS, SOLVE, MOVE = 1, 2, 4, 8
WHOLE = BEGIN | ROWS | SOLVE
ASKED = 100  # returned by a tick that stopped because distances are left to Coal

STATUS_OF = {
    SOLVED: Status.SOLVED,
    ITERATION_LIMIT: Status.ITERATION_LIMIT,
    FAILED: Status.FAILED,
}


@entrance
def motion_alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, t: float, dt: float, fading: bool,
    part: int,
) -> int:  # fmt: skip
    """Run a tick of motion generation, or parts of it, in the parts of a workspace from 1 on."""
    m = MotionBlocks(
        part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1),
        part_of(floats, whole, tables, 2), part_of(floats, whole, tables, 3),
        part_of(floats, whole, tables, 4), part_of(floats, whole, tables, 5), floats, whole, tables,
    )  # fmt: skip
    how = SOLVED
    if part & BEGIN and motion_begin(m, t) > 0:
        return ASKED
    if part & ROWS:
        write_rows(m)
    if part & SOLVE:
        how = solve_motion(m, t, fading)
    if part & MOVE:
        move_on(m, dt)
    return how


@entrance
def levels_alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, slack: np.ndarray
) -> None:
    """Write by how much the answer of a tick violates each level [levels]."""
    m = MotionBlocks(
        part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1),
        part_of(floats, whole, tables, 2), part_of(floats, whole, tables, 3),
        part_of(floats, whole, tables, 4), part_of(floats, whole, tables, 5), floats, whole, tables,
    )  # fmt: skip
    measure_levels(m, slack)


class StaleMotionError(EquipoiseError):
    """The hierarchy of a tick was asked for after the generator had moved on."""


class Part(NamedTuple):
    """One hierarchy of a blend: its share, the problem and its optimum."""

    share: float
    hierarchy: Hierarchy
    solution: Solution


class MotionStep:
    """What one tick of motion generation gives.

    `q_ref` (nq,) and `v_ref` (nv,) belong to the same moment `t` [s]. The hierarchy and its
    solution are put together when they are asked for, which has to be before the next tick.
    """

    def __init__(self, t: float, q_ref: Array, v_ref: Array, generator: MotionGenerator) -> None:
        self.t, self.q_ref, self.v_ref = t, q_ref, v_ref
        self._generator, self._stamp = generator, generator.stamp
        self._problem: tuple[Hierarchy, Solution] | None = None
        self._kin: Kinematics | None = None

    @property
    def kin(self) -> Kinematics:
        """The kinematics at `q_ref`, moving with `v_ref`."""
        if self._kin is None:
            self._kin = self._generator.robot.at(self.q_ref, self.v_ref, self.t)
        return self._kin

    @property
    def hierarchy(self) -> Hierarchy:
        """The problem that was solved: of a blend the part of what counts fully."""
        return self._solved()[0]

    @property
    def solution(self) -> Solution:
        """Its answer; of a blend the blended velocity with its violation."""
        return self._solved()[1]

    @property
    def parts(self) -> list[Part]:
        """The hierarchies of the blend with their shares and optima: the fullest first."""
        self._require_newest()
        return self._generator.parts()

    def _solved(self) -> tuple[Hierarchy, Solution]:
        if self._problem is None:
            self._require_newest()
            self._problem = self._generator.solved()
        return self._problem

    def _require_newest(self) -> None:
        self._generator.require(self._stamp)


class MotionGenerator:
    """Levels of tasks, highest priority first, solved at the reference posture.

    `fades` tells by name which tasks come and go. With our own solver (`make_solver("active_set")`)
    a tick is one call of a kernel; any other is given the hierarchy as an object.
    Source: section III-C, eqs. (14)-(16). Differs from the print: contact rows belong into level 0
    (see `ContactTask`), so that the projection (16) is the identity.
    What had better be otherwise on this robot is warned of (`AdviceWarning`) unless `advise` is
    off.
    Raises: `InputError` for a period that is not positive, or so long that a task would go past
    what it approaches (`rate * dt > 1`).
    """

    def __init__(
        self,
        robot: Robot,
        levels: Sequence[Sequence[Task]],
        solver: HierarchySolver | Callable[[], HierarchySolver],
        dt: float,
        q_start: Array,
        *,
        fades: Mapping[str, Fade] | None = None,
        t_start: float = 0.0,
        advise: bool = True,
    ) -> None:
        self.robot, self.dt = robot, require_period(dt)
        require_rates([task for level in levels for task in level], self.dt)
        self.levels = tuple(tuple(level) for level in levels)
        self.fades = dict(fades or {})
        self.solver = solver() if callable(solver) else solver
        self._more_solvers: list[HierarchySolver] = []
        self._new_solver = solver if callable(solver) else None
        self.stamp = 0
        self.lay_out_again: Callable[[float], None] = self._lay_out_again
        q = real_vector("q_start", q_start, robot.nq)
        self._lay_out(q, t_start)
        if advise:
            self._advise(robot.at(q, None, t_start))

    def _advise(self, kin: Kinematics) -> None:
        """Warn of what had better be otherwise on this robot."""
        for task in (task for level in self.levels for task in level):
            for sentence in task.advice(self.robot, kin):
                warnings.warn(sentence, AdviceWarning, stacklevel=3)

    def _lay_out(self, q: Array, t: float) -> None:
        """Make a workspace for the tasks as they are at `q` (nq,) and time `t` [s]."""
        robot = self.robot
        program = MotionProgram(robot, self.levels, self.fades, robot.at(q, None, t), t)
        frames = program.frames
        workspace = Workspace(
            {"tree": tree_of(robot.model, frames), **program.shapes(len(frames))},
            program.memory,
            STAGES,
        )
        fill_tree(workspace.tree, robot.model, frames)
        program.fill(workspace, lambda frame: frames.index(robot.frame_id(frame)))
        self.work_in(workspace, program, q)

    def work_in(self, workspace: Workspace, program: MotionProgram, q: Array) -> None:
        """Work in a workspace that was laid out by a program, from `q` (nq,) on."""
        self.program, self.workspace = program, workspace
        self._blocks = (workspace.floats, workspace.integers, workspace.tables)
        self._state, self._tasks = workspace.parts["reference"], workspace.parts["tasks"]
        self._state.q[:] = q
        self._tasks.clock[TICK] = self.dt
        self._memory = KinematicsMemory(self.robot, workspace, FIRST)
        self.one_call = isinstance(self.solver, ActiveSet) and not program.needs_python
        targets = program.targets
        self.asks_before = bool(targets.given or targets.live or program.contacts.placed)
        self._own = isinstance(self.solver, ActiveSet)

    @property
    def q_ref(self) -> Array:
        """The reference configuration (nq,) of the next tick."""
        return self._state.q.copy()

    def reset(self, q: Array, v: Array | None = None) -> None:
        """Go on from another reference `q` (nq,), moving with `v` (nv,); nothing else is forgotten.

        Raises: `ShapeError`, `NonFiniteError`, `InputError`.
        """
        self._state.q[:] = real_vector("q", q, self.robot.nq)
        self._tasks.v_ref[:] = 0.0 if v is None else real_vector("v", v, self.robot.nv)

    def step(self, t: float) -> MotionStep:
        """Solve at time `t` [s], return the reference of this moment and move on by `dt`.

        Raises: `InputError` for what is no time.
        """
        t = time_of(t)
        if self.one_call:
            q_ref = self._state.q.copy()  # it stays until the move
            self._solve_in_one(t, MOVE)
            self.stamp += 1
            return MotionStep(t, q_ref, self._tasks.v_ref.copy(), self)
        self.solve(t)
        self.stamp += 1
        step = MotionStep(t, self._state.q.copy(), self._tasks.v_ref.copy(), self)
        self.move_on()
        return step

    def solve(self, t: float) -> int:
        """Solve at time `t` [s], leaving q_ref and v_ref in the workspace."""
        if self.one_call:
            return self._solve_in_one(t, 0)
        self.begin(t)
        return self.finish(t)

    def _solve_in_one(self, t: float, move: int) -> int:
        """Solve by a call of the kernel, two if Coal is asked; move on if `move` says so."""
        if self.asks_before:
            self.program.write_before(self.workspace, t)
        how: int = motion_alone(*self._blocks, t, self.dt, bool(self.fades), WHOLE | move)
        if how != ASKED:
            return how
        self.program.ask_coal(self.workspace)
        return motion_alone(*self._blocks, t, self.dt, bool(self.fades), ROWS | SOLVE | move)

    def begin(self, t: float) -> None:
        """Write the problem of time `t` [s], which `finish` solves."""
        program, workspace = self.program, self.workspace
        if self.asks_before:
            program.write_before(workspace, t)
        if motion_alone(*self._blocks, t, self.dt, False, BEGIN) == ASKED:
            program.ask_coal(workspace)
        if program.needs_python and not program.write_plain(workspace, self.kinematics(t), t):
            self.lay_out_again(t)
            self.begin(t)
            return
        motion_alone(*self._blocks, t, self.dt, False, ROWS)

    def finish(self, t: float) -> int:
        """Solve what `begin` wrote, leaving q_ref and v_ref in the workspace."""
        if not self._own:
            return self._solve_elsewhere(t)
        how: int = motion_alone(*self._blocks, t, self.dt, bool(self.fades), SOLVE)
        return how

    def move_on(self) -> None:
        """Let the reference follow v_ref for a period."""
        motion_alone(*self._blocks, 0.0, self.dt, False, MOVE)

    def _lay_out_again(self, t: float) -> None:
        """Make room for tasks that have other rows than before; the search starts cold."""
        v = self._tasks.v_ref.copy()
        self._lay_out(self._state.q.copy(), t)
        self._tasks.v_ref[:] = v

    @property
    def out_of_reach(self) -> dict[str, float]:
        """By task how far [m] a frame is from a target that it cannot get to, and waits for.

        A radian counts as 0.2 m. Empty where every target is followed.
        """
        return self.program.missed(self.workspace)

    def measure_levels(self, slack: Array) -> None:
        """Write how much the newest answer violates each level (levels,), as `Solution.slack`."""
        levels_alone(*self._blocks, slack)

    def require(self, stamp: int) -> None:
        """Refuse to answer for a tick that is gone. Raises: `StaleMotionError`."""
        if stamp != self.stamp:
            raise StaleMotionError(
                "the generator has moved on: ask for hierarchy and solution before the next step"
            )

    def kinematics(self, t: float) -> Kinematics:
        """Return the kinematics of the reference in the workspace, stale with the next tick."""
        self._memory.stamp += 1
        self._state.v[:] = self._tasks.v_ref
        return Kinematics(self._memory, t)

    # -- another solver -------------------------------------------------------------------------

    def _solve_elsewhere(self, t: float) -> int:
        """Let a solver of another kind answer the hierarchies of the moment."""
        weights = np.array([fade.weight(t) for fade in self.fades.values()])
        self._tasks.weights[: len(weights)] = weights
        between = sorted({float(w) for w in weights if 0.0 < w < 1.0})
        self._answers, v = [], np.zeros(self.robot.nv)
        for i, (below, least) in enumerate(zip([0.0, *between], [*between, 1.0], strict=True)):
            hierarchy = self.program.hierarchy(self.workspace, weights, least)
            solution = self._solver(i).solve(hierarchy)
            self._answers.append(Part(least - below, hierarchy, solution))
            v += (least - below) * solution.v
        statuses = [part.solution.status for part in self._answers]
        worst = max(statuses, key=list(STATUS_OF.values()).index)
        self._tasks.v_ref[:] = 0.0 if worst is Status.FAILED else v
        self._tasks.flags[STATUS] = list(STATUS_OF.values()).index(worst)
        return int(self._tasks.flags[STATUS])

    def _solver(self, i: int) -> HierarchySolver:
        """Return the solver of the i-th part: each starts from its own last answer."""
        if i == 0:
            return self.solver
        while len(self._more_solvers) < i:
            new = self._new_solver or type(self.solver)
            self._more_solvers.append(new())
        return self._more_solvers[i - 1]

    # -- what was solved, as objects ---------------------------------------------------------------

    def parts(self) -> list[Part]:
        """Return the hierarchies of the last tick's blend with shares and optima."""
        if not self._own:
            return self._answers
        tasks, found = self._tasks, []
        weights = tasks.weights[: len(self.fades)]
        for i in range(int(tasks.flags[USED])):
            least = float(tasks.thresholds[i]) if self.fades else 1.0
            share = float(tasks.shares[i]) if self.fades else 1.0
            hierarchy = self.program.hierarchy(self.workspace, weights, least)
            search = self.workspace.parts[f"search{i}"]
            status = STATUS_OF[int(tasks.flags[STATUS])]
            v, works = search.v.copy(), int(search.numbers[WORKS])
            found.append(
                Part(share, hierarchy, describe(hierarchy, v, status, "active_set", works))
            )
        return found

    def solved(self) -> tuple[Hierarchy, Solution]:
        """Return the last tick's problem (of what counts fully) and its answer, blended."""
        parts = self.parts()
        _, hierarchy, settled = parts[-1]
        if len(parts) == 1:
            return hierarchy, settled
        status = STATUS_OF[int(self._tasks.flags[STATUS])]
        v = self._tasks.v_ref.copy()
        if status is Status.FAILED:
            v = np.full(hierarchy.n, np.nan)
        work = sum(part.solution.iterations for part in parts)
        return hierarchy, describe(hierarchy, v, status, settled.solver, work)
