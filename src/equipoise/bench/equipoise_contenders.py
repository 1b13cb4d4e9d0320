"""Our own tick in the race: the whole, its parts and the engine; DAQP on the same rows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from importlib.metadata import version
from time import perf_counter_ns

import daqp
import numpy as np

from equipoise.bench.interleave import TURN
from equipoise.bench.problem import HANDS, Problem
from equipoise.bench.unreachable_targets import throw_hands
from equipoise.hqp import Hierarchy, Rows, Status, make_solver
from equipoise.kinematics import Kinematics
from equipoise.motion import MotionGenerator
from equipoise.robots import Robot
from equipoise.simulation.build.engines import make_engine
from equipoise.spatial import Array
from equipoise.tasks import Task
from equipoise.wbc.tick import (
    BEGIN_LAW,
    BEGIN_MOTION,
    MOVE,
    RUN_LAW,
    SOLVE_MOTION,
    WANT,
    WRITE_ROWS,
    tick,
)

_EQUALITY, _NO_BOUND = 5, 1e30
_SOFTNESS = 1e-6  # with it DAQP answers all ticks of the tray; with 1e-10 not, and more slowly
_ANSWERED = (1, 2)


class OwnTick:
    """The closed loop of the tray: the whole controller in one call, and the rigid engine."""

    turn = TURN

    def __init__(self, problem: Problem) -> None:
        self.problem, self._controller = problem, problem.make_controller()
        self._plant = make_engine(
            problem.simulation.scenario, problem.simulation.setup, problem.q_start
        )
        self._names = (f"tick/{problem.name}/tray", f"rigid/{problem.name}/tray")
        self.failures: Counter[str] = Counter()
        words = (
            "the whole: motion generation, law and supervisor, in one call",
            "the rigid engine's period, not part of the tick",
        )
        self.remarks = dict(zip(self._names, words, strict=True))

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks of the loop."""
        times = [self._tick(k * self.problem.dt) for k in range(first, first + count)]
        return {name: [ns[i] for ns in times] for i, name in enumerate(self._names)}

    def _tick(self, t: float) -> tuple[int, int]:
        state, step = self._plant.state, self._controller.step
        began = perf_counter_ns()
        command = step(t, state.q, state.v, state.lam)
        ended = perf_counter_ns()
        self._plant.step(command.tau)
        simulated = perf_counter_ns()
        self.failures[self._names[0]] += not _is_well(command.motion_status)
        return ended - began, simulated - ended


class OwnVariant:
    """The whole controller on other levels, told that the robot does what its reference says."""

    turn = TURN

    def __init__(
        self, problem: Problem, case: str, levels: Sequence[Sequence[Task]], remark: str
    ) -> None:
        self.problem, self._controller = problem, problem.make_controller(levels)
        self._row = f"tick/{problem.name}/{case}"
        self._q, self._v = problem.q_start, np.zeros(problem.robot.nv)
        self._lam = np.zeros(self._controller.contacts.size)
        self.failures: Counter[str] = Counter()
        self.remarks = {self._row: remark}

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks."""
        times, step = [], self._controller.step
        for k in range(first, first + count):
            t = k * self.problem.dt
            began = perf_counter_ns()
            command = step(t, self._q, self._v, self._lam)
            times.append(perf_counter_ns() - began)
            self._q, self._v = command.q_ref, command.v_ref
            self.failures[self._row] += not _is_well(command.motion_status)
        return {self._row: times}


class HeldPosture(Task):
    """A task in plain Python: one joint is drawn to where it was; `spent` [ns] is its own time."""

    def __init__(self, robot: Robot) -> None:
        super().__init__("plain")
        self._column, self._there = robot.nv - 1, float(robot.q_half_sitting[-1])
        self.spent: list[int] = []

    labels, units = ("angle",), ("rad",)

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return one row."""
        began = perf_counter_ns()
        A = np.zeros((1, kin.robot.nv))
        A[0, self._column] = 1.0
        wanted = np.array([self._there - kin.q[-1]])
        rows = Rows(self.name, "rad/s", self.labels, A, wanted, wanted)
        self.spent.append(perf_counter_ns() - began)
        return rows

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [rad] the joint is away."""
        return np.array([self._there - kin.q[-1]])


def variants(problem: Problem) -> list[OwnVariant]:
    """Return the controller with 8 pairs, with all of the scenario's, and with a plain task."""
    *above, last = problem.levels
    return [
        OwnVariant(problem, "pairs", problem.levels, f"{len(problem.pairs)} pairs, no engine"),
        OwnVariant(
            problem, "all_pairs", problem.levels_with(problem.all_pairs),
            f"{len(problem.all_pairs)} pairs, no engine",
        ),
        OwnVariant(
            problem, "plain", [*above, [HeldPosture(problem.robot)], last],
            "8 pairs and a task in plain Python, no engine",
        ),
    ]  # fmt: skip


class OwnParts:
    """The same tick taken apart: its kernel called for one part after the other.

    Each part is a call of its own, which costs what the row `call` says; the whole has it once.
    """

    turn = TURN

    def __init__(self, problem: Problem) -> None:
        self.problem, self._controller = problem, problem.make_controller()
        workspace = self._controller.workspace
        self._blocks = workspace.floats, workspace.integers, workspace.tables
        robot, held = problem.robot, self._controller.contacts
        size = 2 * robot.nq + 3 * robot.nv + robot.na + held.size
        self._result = np.empty(size)  # never too short for what a tick gives
        name = problem.name
        self._parts = {
            f"tick/{name}/call": 0,
            f"tick/{name}/rows": BEGIN_MOTION | WRITE_ROWS,
            f"hqp/{name}/tray": SOLVE_MOTION,
            f"tick/{name}/law": WANT | BEGIN_LAW | RUN_LAW,
            f"tick/{name}/move": MOVE,
        }
        self.failures: Counter[str] = Counter()
        words = (
            "calling the kernel, which each part below does once",
            "kinematics, targets, distances and rows",
            "the hierarchy",
            "contacts, law and base wrench",
            "the step of the reference",
        )
        self.remarks = dict(zip(self._parts, words, strict=True))

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks in which the robot does what its reference says."""
        times: dict[str, list[int]] = {name: [] for name in self._parts}
        controller, lam = self._controller, np.zeros(self._controller.contacts.size)
        state, tasks = controller.workspace.parts["reference"], controller.workspace.parts["tasks"]
        for k in range(first, first + count):
            t = k * self.problem.dt
            for name, part in self._parts.items():
                began = perf_counter_ns()
                tick(*self._blocks, t, state.q, tasks.v_ref, lam, part, self._result)
                times[name].append(perf_counter_ns() - began)
            self.failures[f"hqp/{self.problem.name}/tray"] += not _is_well(controller.motion_status)
        return times


class HardCase:
    """Motion generation alone, the hands thrown half a metre out of reach every ten ticks."""

    turn = TURN

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        levels = throw_hands(problem, HANDS)
        self._motion = MotionGenerator(
            problem.robot, levels, make_solver("active_set"), problem.dt, problem.q_start
        )
        self._row = f"hqp/{problem.name}/hard"
        self.failures: Counter[str] = Counter()
        self._active: list[int] = []

    @property
    def remarks(self) -> dict[str, str]:
        """How many bounds were active."""
        return {self._row: f"median of {np.median(self._active or [0]):.0f} bounds active"}

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks; only the solver is timed."""
        times, motion, dt = [], self._motion, self.problem.dt
        for k in range(first, first + count):
            t = k * dt
            motion.begin(t)
            began = perf_counter_ns()
            motion.finish(t)
            times.append(perf_counter_ns() - began)
            _, solution = motion.solved()
            motion.move_on()
            self._active.append(int((np.abs(solution.active) == 1).sum()))
            self.failures[self._row] += not _is_well(solution.status)
        return {self._row: times}


class DaqpBeside:
    """DAQP's hierarchical mode on the rows of our ticks, of the tray or of the hard case."""

    turn = TURN

    def __init__(self, problem: Problem, case: str) -> None:
        self.problem = problem
        levels = throw_hands(problem, HANDS) if case == "hard" else problem.levels
        self._motion = MotionGenerator(
            problem.robot, levels, make_solver("active_set"), problem.dt, problem.q_start
        )
        self._row = f"daqp/{problem.name}/{case}"
        self.failures: Counter[str] = Counter()
        words = f"DAQP {version('daqp')}, same rows, the library's call alone, started cold"
        self.remarks = {self._row: words}

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks; only DAQP is timed."""
        times = []
        for k in range(first, first + count):
            spent, answered = timed_daqp(self._motion.step(k * self.problem.dt).hierarchy)
            times.append(spent)
            self.failures[self._row] += not answered
        return {self._row: times}


def timed_daqp(hierarchy: Hierarchy) -> tuple[int, bool]:
    """Return the time [ns] of DAQP's call alone, its arrays made ready, and whether it answered."""
    n, m = hierarchy.n, len(hierarchy.lower)
    sense = np.zeros(m, dtype=np.int32)
    sense[hierarchy.lower == hierarchy.upper] = _EQUALITY
    levels = np.array([0, *hierarchy.ends], dtype=np.int32)
    upper = np.minimum(hierarchy.upper, _NO_BOUND)
    lower = np.maximum(hierarchy.lower, -_NO_BOUND)
    H, f, A = np.eye(n), np.zeros(n), np.ascontiguousarray(hierarchy.A)
    began = perf_counter_ns()
    v, _, flag, _ = daqp.solve(
        H, f, A, upper, lower, sense, break_points=levels, rho_soft=_SOFTNESS
    )
    spent = perf_counter_ns() - began
    return spent, flag in _ANSWERED and bool(np.isfinite(v).all())


def _is_well(status: Status) -> bool:
    return status is Status.SOLVED
