"""How time grows with unknowns, tasks, levels, contacts, collision pairs and rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter_ns

import numpy as np

from equipoise.bench.interleave import TURN, Contender, Progress, interleave
from equipoise.bench.problem import Problem, make_problem
from equipoise.bench.rows import Row
from equipoise.contacts import ContactStack, SoleContact
from equipoise.control import Measurement, PassivityController, Reference
from equipoise.hqp import Hierarchy, Rows, make_solver
from equipoise.motion import MotionGenerator
from equipoise.robots import Robot, Sole, get_robot, named_robots
from equipoise.tasks import (
    AvoidanceTask,
    FramePoseTask,
    JointLimitsTask,
    PostureTask,
    Task,
)
from equipoise.trajectories import FixedPose

DT = 0.001
ROWS = (50, 100, 200, 400, 800)
SIZES = (16, 32, 64, 128)
UNKNOWNS, EQUALITIES = 36, 12


class Repeated:
    """A call that is timed again and again."""

    turn = TURN

    def __init__(self, row: str, call: Callable[[], object], remark: str = "") -> None:
        self.row, self._call = row, call
        self.failures, self.remarks = {row: 0}, {row: remark} if remark else {}

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Call so many times."""
        times = []
        for _ in range(count):
            began = perf_counter_ns()
            self._call()
            times.append(perf_counter_ns() - began)
        return {self.row: times}


def growth(ticks: int, report: Progress | None = None) -> list[Row]:
    """Return rows `growth/WHAT/SIZE`, the sizes of each table interleaved; on HRP-2."""
    problem, rows = make_problem("hrp2"), []
    for table in (
        _dof(),
        _tasks(),
        _levels(),
        _contacts(problem),
        _pairs(problem),
        _rows(),
        _unknowns(),
    ):
        rows += interleave(table, ticks, report)
    return rows


def _motion(robot: Robot, levels: Sequence[Sequence[Task]], q: np.ndarray) -> Callable[[], object]:
    motion = MotionGenerator(robot, levels, make_solver("active_set"), DT, q)
    return lambda: motion.step(0.0)


def _held(robot: Robot, frames: Sequence[str]) -> list[Task]:
    q = robot.q_half_sitting
    kin = robot.at(q)
    return [FramePoseTask(frame, frame, FixedPose(kin.placement(frame))) for frame in frames]


def _posture(robot: Robot) -> Task:
    return PostureTask("posture", robot, robot.q_half_sitting[robot.nq_base :])


def _dof() -> list[Contender]:
    """Motion of every robot that is installed: feet if it has any; hands and limits; posture."""
    table: list[Contender] = []
    for name, known in named_robots().items():
        if known.missing:
            continue
        robot = get_robot(name)
        feet = _held(robot, [sole.frame for sole in robot.soles])
        hands = _held(robot, [palm.frame for palm in robot.palms])
        levels = [[*hands, JointLimitsTask("limits", robot)], [_posture(robot)]]
        levels = [feet, *levels] if feet else levels
        call = _motion(robot, levels, robot.q_half_sitting)
        table.append(Repeated(f"growth/dof/{robot.nv}-{name}", call))
    return table


def _eight(robot: Robot) -> list[Task]:
    """Return eight frame tasks that hold what is held already: 48 rows, so some are redundant."""
    links = [link for names in robot.parts.values() for link in names]
    ends = [sole.frame for sole in robot.soles] + [palm.frame for palm in robot.palms]
    return _held(robot, [*ends, *[link for link in links if link not in ends][:4]])


def _tasks() -> list[Contender]:
    """Motion with 1 to 8 frame tasks on one level, the posture below."""
    robot = get_robot("hrp2")
    table: list[Contender] = []
    for count in (1, 2, 4, 8):
        levels = [_eight(robot)[:count], [_posture(robot)]]
        table.append(
            Repeated(f"growth/tasks/{count}", _motion(robot, levels, robot.q_half_sitting))
        )
    return table


def _levels() -> list[Contender]:
    """Motion with eight frame tasks on 1 to 8 levels, the posture below."""
    robot = get_robot("hrp2")
    table: list[Contender] = []
    for count in (1, 2, 4, 8):
        tasks, each = _eight(robot), 8 // count
        levels = [tasks[i * each : (i + 1) * each] for i in range(count)]
        call = _motion(robot, [*levels, [_posture(robot)]], robot.q_half_sitting)
        table.append(Repeated(f"growth/levels/{count}", call))
    return table


def _contacts(problem: Problem) -> list[Contender]:
    """The law with 1 to 4 flat contacts of six rows: soles, then palms."""
    robot, q = problem.robot, problem.q_start
    kin = robot.at(q)
    soles = list(robot.soles) + [
        Sole(palm.name, palm.frame, -0.02, 0.02, -0.02, 0.02) for palm in robot.palms
    ]
    flat = [SoleContact.standing(sole, kin, supporting=i < 2) for i, sole in enumerate(soles)]
    gains = problem.simulation.controller.settings.gains
    table: list[Contender] = []
    for count in range(1, len(flat) + 1):
        stack = ContactStack(flat[:count])
        law = PassivityController(robot, stack, gains, DT)
        still = np.zeros(robot.nv)
        measured = Measurement(q, still, np.zeros(stack.size))
        reference = Reference(q, still, np.zeros(stack.regulated_rows.size))
        table.append(Repeated(f"growth/contacts/{count}", _stepping(law, measured, reference)))
    return table


def _stepping(
    law: PassivityController, measured: Measurement, reference: Reference
) -> Callable[[], object]:
    return lambda: law.step(0.0, measured, reference)


def _pairs(problem: Problem) -> list[Contender]:
    """Motion with hands, limits and 0 to all pairs of the tray that were chosen."""
    robot = problem.robot
    avoidance = next(t for lv in problem.levels for t in lv if isinstance(t, AvoidanceTask))
    scene = problem.simulation.setup.scene
    table: list[Contender] = []
    others = [[t for t in level if t is not avoidance] for level in problem.levels]
    for count in (0, 2, 4, 8):
        task = AvoidanceTask(
            avoidance.name,
            scene,
            problem.pairs[:count],
            influence=avoidance.influence,
            security=avoidance.security,
            damping=avoidance.damping,
        )
        levels = [others[0], others[1], [*others[2], *([task] if count else [])], *others[3:]]
        table.append(Repeated(f"growth/pairs/{count}", _motion(robot, levels, problem.q_start)))
    return table


def _rows() -> list[Contender]:
    """The hierarchy alone with 50 to 800 inequalities that never act: a fixed active set."""
    rng = np.random.default_rng(5)
    fixed = rng.normal(size=(EQUALITIES, UNKNOWNS))
    wanted = rng.normal(size=EQUALITIES)
    slack = rng.normal(size=(max(ROWS), UNKNOWNS))
    table: list[Contender] = []
    for count in ROWS:
        far = np.full(count, 1e3)
        inner = Rows("inner", "1", _labels(count), slack[:count], -far, far)
        first = Rows("first", "1", _labels(EQUALITIES), fixed, wanted, wanted)
        least = Rows("least", "1", _labels(UNKNOWNS), np.eye(UNKNOWNS), *[np.zeros(UNKNOWNS)] * 2)
        hierarchy = Hierarchy.stack([[first], [inner], [least]], UNKNOWNS)
        table.append(Repeated(f"growth/rows/{count}", _solving(hierarchy)))
    return table


def _unknowns() -> list[Contender]:
    """The hierarchy alone with 16 to 128 unknowns: a third fixed, all bounded, all drawn to 0."""
    rng = np.random.default_rng(6)
    table: list[Contender] = []
    for n in SIZES:
        wanted, one, zero = rng.normal(size=n // 3), np.ones(n), np.zeros(n)
        first = Rows("first", "1", _labels(n // 3), rng.normal(size=(n // 3, n)), wanted, wanted)
        box = Rows("box", "1", _labels(n), np.eye(n), -10.0 * one, 10.0 * one)
        least = Rows("least", "1", _labels(n), np.eye(n), zero, zero)
        hierarchy = Hierarchy.stack([[first], [box], [least]], n)
        table.append(Repeated(f"growth/unknowns/{n}", _solving(hierarchy)))
    return table


def _solving(hierarchy: Hierarchy) -> Callable[[], object]:
    solver = make_solver("active_set")
    return lambda: solver.solve(hierarchy)


def _labels(count: int) -> tuple[str, ...]:
    return tuple(str(i) for i in range(count))


def linear_share(rows: Sequence[Row]) -> float:
    """Return how much the time per further row changes over the table of rows: 1 is a line.

    The slope of the upper half over that of the lower half; quadratic growth would give 2.7.
    """
    times = {
        int(row.name.rsplit("/", 1)[1]): row.median_us
        for row in rows
        if row.name.startswith("growth/rows/")
    }
    low, middle, high = min(ROWS), ROWS[-2], max(ROWS)
    lower = (times[middle] - times[low]) / (middle - low)
    return ((times[high] - times[middle]) / (high - middle)) / lower
