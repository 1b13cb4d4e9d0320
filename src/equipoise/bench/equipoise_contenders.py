"""Our own tick in the race: the whole, its parts and the engine; DAQP on the same rows."""

from __future__ import annotations

from collections import Counter
from importlib.metadata import version
from time import perf_counter_ns

import daqp
import numpy as np

from equipoise.bench.interleave import TURN
from equipoise.bench.problem import HANDS, Problem
from equipoise.bench.unreachable_targets import throw_hands
from equipoise.control import Measurement, Target
from equipoise.hqp import Hierarchy, HierarchySolver, Solution, make_solver
from equipoise.motion import MotionGenerator

_EQUALITY, _NO_BOUND = 5, 1e30
_SOFTNESS = 1e-6  # with it DAQP answers all ticks of the tray; with 1e-10 not, and more slowly
_ANSWERED = (1, 2)


class TimedSolver:
    """Our solver, timed where it is called: `spent` [ns] is the last call's."""

    def __init__(self) -> None:
        self._solver: HierarchySolver = make_solver("active_set")
        self.name = self._solver.name
        self.spent = 0

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Return the solver's answer."""
        began = perf_counter_ns()
        solution = self._solver.solve(hierarchy)
        self.spent = perf_counter_ns() - began
        return solution


class OwnTick:
    """The closed loop of the tray: motion, law and rigid engine; each timed, and its parts."""

    turn = TURN

    def __init__(self, problem: Problem) -> None:
        self.problem, self._solver = problem, TimedSolver()
        simulation = problem.simulation
        self._motion = MotionGenerator(
            problem.robot, problem.levels, self._solver, problem.dt, problem.q_start
        )
        self._controller, self._engine = simulation.controller, simulation.engine
        name = problem.name
        self._names = (
            f"tick/{name}/tray",
            f"tick/{name}/rows",
            f"hqp/{name}/tray",
            f"tick/{name}/law",
            f"rigid/{name}/tray",
        )
        self.failures: Counter[str] = Counter()
        words = (
            "the whole: motion generation and law",
            "its kinematics, rows and integration",
            "its hierarchy",
            "its contacts, law and base wrench",
            "the rigid engine's period, not part of the tick",
        )
        self.remarks = dict(zip(self._names, words, strict=True))

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks of the loop."""
        times = [self._tick(k * self.problem.dt) for k in range(first, first + count)]
        return {name: [ns[i] for ns in times] for i, name in enumerate(self._names)}

    def _tick(self, t: float) -> tuple[int, ...]:
        state = self._engine.state
        began = perf_counter_ns()
        step = self._motion.step(t)
        moved = perf_counter_ns()
        target = Target(step.q_ref, step.v_ref, self.problem.lam_ref(t))
        command = self._controller.step(t, Measurement(state.q, state.v, state.lam), target)
        ended = perf_counter_ns()
        self._engine.step(command.tau)
        simulated = perf_counter_ns()
        self.failures[self._names[2]] += not _is_answer(step.solution)
        spent = self._solver.spent
        return ended - began, moved - began - spent, spent, ended - moved, simulated - ended


class HardCase:
    """Motion generation alone, the hands thrown half a metre out of reach every ten ticks."""

    turn = TURN

    def __init__(self, problem: Problem) -> None:
        self.problem, self._solver = problem, TimedSolver()
        levels = throw_hands(problem, HANDS)
        self._motion = MotionGenerator(
            problem.robot, levels, self._solver, problem.dt, problem.q_start
        )
        self._row = f"hqp/{problem.name}/hard"
        self.failures: Counter[str] = Counter()
        self._active: list[int] = []

    @property
    def remarks(self) -> dict[str, str]:
        """How many bounds were active."""
        return {self._row: f"median of {np.median(self._active or [0]):.0f} bounds active"}

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks."""
        times = []
        for k in range(first, first + count):
            solution = self._motion.step(k * self.problem.dt).solution
            times.append(self._solver.spent)
            self._active.append(int((np.abs(solution.active) == 1).sum()))
            self.failures[self._row] += not _is_answer(solution)
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


def _is_answer(solution: Solution) -> bool:
    return solution.solved and bool(np.isfinite(solution.v).all())
