"""Pink on our task set: frame tasks of hands and feet, a posture, limits, and 8 pairs if asked."""

from __future__ import annotations

from importlib.metadata import version
from time import perf_counter_ns

import pink
import pinocchio as pin
from pink.barriers import SelfCollisionBarrier
from pink.exceptions import PinkError
from pink.tasks import FrameTask, PostureTask

from equipoise.bench.interleave import TURN
from equipoise.bench.problem import FEET, Problem
from equipoise.spatial import Array
from equipoise.tasks import AvoidanceTask

FEET_COST, HAND_COST, POSTURE_COST = 100.0, 1.0, 1e-3
SOLVER = "daqp"


class PinkPeer:
    """One velocity a tick, integrated; the targets are computed outside of the clock."""

    turn = TURN

    def __init__(self, problem: Problem, *, collisions: bool) -> None:
        self.problem = problem
        self.row = f"peer/{'pink_collisions' if collisions else 'pink'}/{problem.name}"
        self.failures = {self.row: 0}
        self.remarks = {self.row: f"pin-pink {version('pin-pink')} with {SOLVER}"}
        model = problem.robot.model.copy()
        geometry = _geometry(problem) if collisions else None
        self._configuration = pink.Configuration(
            model, model.createData(), problem.q_start, collision_model=geometry
        )
        self._tasks, self._frames = [], []
        for name, task in problem.frame_tasks().items():
            cost = FEET_COST if name in FEET else HAND_COST
            frame = str(task.frame)
            follow = FrameTask(frame, position_cost=cost, orientation_cost=cost)
            self._frames.append((follow, task.target))
            self._tasks.append(follow)
        posture = PostureTask(cost=POSTURE_COST, gain=2.0 * problem.dt)
        posture.set_target(problem.robot.q_half_sitting)
        self._tasks.append(posture)
        self._barriers = [_barrier(problem)] if collisions else []

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks."""
        dt = self.problem.dt
        return {self.row: [self._tick(k * dt, dt) for k in range(first, first + count)]}

    def place_of(self, task: str) -> Array:
        """Return where the frame of a task is now (3,) [m]."""
        name = str(self.problem.frame_tasks()[task].frame)
        return self._configuration.get_transform_frame_to_world(name).translation

    def _tick(self, t: float, dt: float) -> int:
        for follow, target in self._frames:
            follow.set_target(target.at(t).T_world_target)
        began = perf_counter_ns()
        try:
            v = pink.solve_ik(
                self._configuration,
                self._tasks,
                dt,
                solver=SOLVER,
                barriers=self._barriers,
                safety_break=False,
            )
            self._configuration.integrate_inplace(v, dt)
        except PinkError:
            self.failures[self.row] += 1
        return perf_counter_ns() - began


def _geometry(problem: Problem) -> pin.GeometryModel:
    scene = problem.simulation.setup.scene
    geometry = scene.geometry.copy()
    geometry.removeAllCollisionPairs()
    for pair in problem.pairs:
        (first,), (second,) = scene.shapes_of(pair.first), scene.shapes_of(pair.second)
        geometry.addCollisionPair(pin.CollisionPair(first, second))
    return geometry


def _barrier(problem: Problem) -> SelfCollisionBarrier:
    task = next(t for level in problem.levels for t in level if isinstance(t, AvoidanceTask))
    gain = task.damping / (task.influence - task.security)
    return SelfCollisionBarrier(
        len(problem.pairs), gain=gain, safe_displacement_gain=0.0, d_min=task.security
    )
