"""mink on our task set: the robot written for MuJoCo, frame tasks, limits, 8 pairs if asked."""

from __future__ import annotations

from importlib.metadata import version
from time import perf_counter_ns
from typing import Any

import coal
import mink
import mujoco
import numpy as np

from equipoise.bench.interleave import TURN
from equipoise.bench.problem import FEET, Problem
from equipoise.physics.mujoco import MujocoOptions
from equipoise.physics.mujoco.conversion import StateConversion
from equipoise.physics.mujoco.names import of_joint
from equipoise.physics.mujoco.robot_model import add_robot, place
from equipoise.spatial import Array
from equipoise.tasks import AvoidanceTask

FEET_COST, HAND_COST, POSTURE_COST = 100.0, 1.0, 1e-3
SOLVER = "daqp"


class MinkPeer:
    """One velocity a tick, integrated; the targets are computed outside of the clock."""

    turn = TURN

    def __init__(self, problem: Problem, *, collisions: bool) -> None:
        self.problem = problem
        self.row = f"peer/{'mink_collisions' if collisions else 'mink'}/{problem.name}"
        self.failures = {self.row: 0}
        self.remarks = {self.row: f"mink {version('mink')} with {SOLVER}"}
        model, names = _model(problem)
        q = _qpos(problem, model, problem.q_start)
        self._configuration = mink.Configuration(model, q=q)
        self._tasks, self._frames = [], []
        for name, task in problem.frame_tasks().items():
            cost = FEET_COST if name in FEET else HAND_COST
            follow = mink.FrameTask(name, "site", position_cost=cost, orientation_cost=cost)
            self._frames.append((follow, task.target))
            self._tasks.append(follow)
        posture = mink.PostureTask(model, cost=POSTURE_COST, gain=2.0 * problem.dt)
        posture.set_target(_qpos(problem, model, problem.robot.q_half_sitting))
        self._tasks.append(posture)
        robot = problem.robot
        joints = [of_joint(name) for name in robot.joint_names]
        self._limits = [
            mink.ConfigurationLimit(model),
            mink.VelocityLimit(model, dict(zip(joints, robot.v_max, strict=True))),
        ]
        if collisions:
            self._limits.append(_avoidance(problem, model, names))

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Run ticks."""
        dt = self.problem.dt
        return {self.row: [self._tick(k * dt, dt) for k in range(first, first + count)]}

    def place_of(self, task: str) -> Array:
        """Return where the frame of a task is now (3,) [m]."""
        return self._configuration.get_transform_frame_to_world(task, "site").translation()

    def _tick(self, t: float, dt: float) -> int:
        for follow, target in self._frames:
            matrix = target.at(t).T_world_target.homogeneous
            follow.set_target(mink.SE3.from_matrix(matrix))
        began = perf_counter_ns()
        try:
            v = mink.solve_ik(
                self._configuration, self._tasks, dt, solver=SOLVER, limits=self._limits
            )
            self._configuration.integrate_inplace(v, dt)
        except mink.MinkError:
            self.failures[self.row] += 1
        return perf_counter_ns() - began


def _model(problem: Problem) -> tuple[Any, dict[str, str]]:
    """Return the MuJoCo model and the name of its shape by body of our scene."""
    robot, spec = problem.robot, mujoco.MjSpec()
    spec.compiler.degree = False
    bodies = add_robot(mujoco, spec, robot, MujocoOptions())
    for name, task in problem.frame_tasks().items():
        frame = robot.model.frames[robot.frame_id(task.frame)]
        place(bodies[frame.parentJoint].add_site(name=name), frame.placement)
    scene, names = problem.simulation.setup.scene, {}
    for body in sorted({name for pair in problem.pairs for name in (pair.first, pair.second)}):
        (index,) = scene.shapes_of(body)
        shape = scene.geometry.geometryObjects[index]
        geom = _shape(bodies[shape.parentJoint], f"shape_of_{body}", shape.geometry)
        place(geom, shape.placement)
        names[body] = geom.name
    return spec.compile(), names


def _shape(body: Any, name: str, geometry: coal.CollisionGeometry) -> Any:
    kinds = mujoco.mjtGeom
    if isinstance(geometry, coal.Box):
        return body.add_geom(name=name, type=kinds.mjGEOM_BOX, size=geometry.halfSide, mass=0.0)
    if isinstance(geometry, coal.Sphere):
        size = [geometry.radius, 0.0, 0.0]
        return body.add_geom(name=name, type=kinds.mjGEOM_SPHERE, size=size, mass=0.0)
    size = [geometry.radius, geometry.halfLength, 0.0]
    round_ended = isinstance(geometry, coal.Capsule)
    kind = kinds.mjGEOM_CAPSULE if round_ended else kinds.mjGEOM_CYLINDER
    return body.add_geom(name=name, type=kind, size=size, mass=0.0)


def _qpos(problem: Problem, model: Any, q: np.ndarray) -> np.ndarray:
    joints = [model.joint(of_joint(name)) for name in problem.robot.joint_names]
    conversion = StateConversion([j.qposadr[0] for j in joints], [j.dofadr[0] for j in joints])
    qpos = np.zeros(model.nq)
    conversion.write_q(q, qpos)
    return qpos


def _avoidance(problem: Problem, model: Any, names: dict[str, str]) -> Any:
    task = next(t for level in problem.levels for t in level if isinstance(t, AvoidanceTask))
    return mink.CollisionAvoidanceLimit(
        model,
        [([names[pair.first]], [names[pair.second]]) for pair in problem.pairs],
        gain=task.damping * problem.dt / (task.influence - task.security),
        minimum_distance_from_collisions=task.security,
        collision_detection_distance=task.influence,
    )
