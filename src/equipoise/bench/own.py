"""Our own tick in the race: the whole, its parts, the engine, and DAQP on the same rows."""

from __future__ import annotations

from time import perf_counter_ns

import daqp
import numpy as np

from equipoise.bench.problem import HANDS, Problem
from equipoise.bench.thrown import throw_hands
from equipoise.control import Measurement, Target
from equipoise.hqp import Hierarchy, make_solver
from equipoise.kinematics import KinematicsEvaluator
from equipoise.motion import MotionGenerator
from equipoise.motion.generator import build_hierarchy

_EQUALITY, _NO_BOUND = 5, 1e30
_SOFTNESS = (
    1e-6  # at which DAQP answers every tick here; with 1e-10 it gives up some, and is slower
)
_DAQP_ANSWERED = (1, 2)


class OwnTick:
    """The closed loop of the tray: motion, law and rigid engine; each timed, and its parts."""

    turn = 1

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.name = problem.name
        simulation = problem.simulation
        self._motion = MotionGenerator(
            problem.robot, problem.levels, make_solver("active_set"), problem.dt, problem.q_start
        )
        self._controller, self._engine = simulation.controller, simulation.engine
        self._solver = make_solver("active_set")
        self._evaluator = KinematicsEvaluator(problem.robot)
        self.failures: dict[str, int] = {}
        self.remarks = {
            f"tick/{self.name}/tray": "motion generation and law",
            f"tick/{self.name}/rows": "kinematics and rows of the hierarchy",
            f"tick/{self.name}/law": "contacts, law and base wrench",
            f"daqp/{self.name}/tray": _daqp_words(),
        }

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run one tick of the loop."""
        t, name, state = first * self.problem.dt, self.name, self._engine.state
        began = perf_counter_ns()
        step = self._motion.step(t)
        moved = perf_counter_ns()
        target = Target(step.q_ref, step.v_ref, self.problem.lam_ref(t))
        command = self._controller.step(t, Measurement(state.q, state.v, state.lam), target)
        ended = perf_counter_ns()
        self._engine.step(command.tau)
        simulated = perf_counter_ns()
        hierarchy = step.hierarchy
        rows_ns = self._rows(t, step.q_ref, step.v_ref)
        solve_ns, solved = timed_solve(self._solver, hierarchy)
        daqp_ns, answered = timed_daqp(hierarchy)
        self._count(f"hqp/{name}/tray", solved)
        self._count(f"daqp/{name}/tray", answered)
        return {
            f"tick/{name}/tray": [ended - began],
            f"tick/{name}/motion": [moved - began],
            f"tick/{name}/rows": [rows_ns],
            f"tick/{name}/law": [ended - moved],
            f"hqp/{name}/tray": [solve_ns],
            f"daqp/{name}/tray": [daqp_ns],
            f"rigid/{name}/tray": [simulated - ended],
        }

    def _rows(self, t: float, q: np.ndarray, v: np.ndarray) -> int:
        began = perf_counter_ns()
        build_hierarchy(self.problem.levels, self._evaluator.at(q, v, t), t)
        return perf_counter_ns() - began

    def _count(self, row: str, well: bool) -> None:
        self.failures[row] = self.failures.get(row, 0) + (not well)


class HardCase:
    """Motion generation alone, the hands thrown half a metre out of reach every ten ticks."""

    turn = 1

    def __init__(self, problem: Problem) -> None:
        self.problem, self.name = problem, problem.name
        levels = throw_hands(problem, HANDS)
        self._motion = MotionGenerator(
            problem.robot, levels, make_solver("active_set"), problem.dt, problem.q_start
        )
        self._solver = make_solver("active_set")
        self.failures: dict[str, int] = {}
        self.remarks = {f"daqp/{self.name}/hard": _daqp_words()}
        self.active_bounds: list[int] = []

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run one tick."""
        name = self.name
        step = self._motion.step(first * self.problem.dt)
        solve_ns, solved = timed_solve(self._solver, step.hierarchy)
        daqp_ns, answered = timed_daqp(step.hierarchy)
        self.active_bounds.append(int((np.abs(step.solution.active) == 1).sum()))
        median = int(np.median(self.active_bounds[-1000:]))
        self.remarks[f"hqp/{name}/hard"] = f"median of {median} bounds active"
        for row, well in ((f"hqp/{name}/hard", solved), (f"daqp/{name}/hard", answered)):
            self.failures[row] = self.failures.get(row, 0) + (not well)
        return {f"hqp/{name}/hard": [solve_ns], f"daqp/{name}/hard": [daqp_ns]}


def timed_solve(solver, hierarchy: Hierarchy) -> tuple[int, bool]:
    """Return the time [ns] of one solution, and whether it is one."""
    began = perf_counter_ns()
    solution = solver.solve(hierarchy)
    spent = perf_counter_ns() - began
    return spent, solution.solved and bool(np.isfinite(solution.v).all())


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
    return spent, flag in _DAQP_ANSWERED and bool(np.isfinite(v).all())


def _daqp_words() -> str:
    from importlib.metadata import version

    return f"DAQP {version('daqp')}, hierarchical mode, same rows, the call alone, started cold"
