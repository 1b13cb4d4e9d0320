"""Which waypoints the robot cannot get to, and by how much it misses each: told before it moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.scenarios import schema
from equipoise.simulation.build.fades import build_fades
from equipoise.simulation.build.levels import slowed_way
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array
from equipoise.tasks import (
    AvoidanceTask,
    ContactTask,
    FloorSupportTask,
    FramePoseTask,
    GazeTask,
    JointAccelerationsTask,
    Task,
)
from equipoise.trajectories import FixedPose, Waypoint

STEP = 0.02  # [s] of an Euler step; the rates of the tasks times it stay below 1
MOST_STEPS = 250  # of the way to a waypoint
EVERY = 0.1  # [s] between postures that are looked at
REST = 1e-3  # [m/s, rad/s] below which the robot has come to rest
# what bounds a way that is out of reach, where its file says nothing
CALM = {"speed": 0.5, "acceleration": 1.0, "turn": 1.0, "turn_acceleration": 2.0}
LEFT_OUT = (AvoidanceTask, GazeTask, JointAccelerationsTask, FloorSupportTask)
NEAR, ALIGNED = 0.002, 0.02  # [m], [rad] up to which a waypoint counts as reached


@dataclass(frozen=True)
class Miss:
    """A task misses the waypoint of a number, at time `t` [s], by `distance` [m], `angle` [rad]."""

    task: str
    number: int
    t: float
    distance: float
    angle: float

    def __str__(self) -> str:
        far = f"{1e3 * self.distance:.0f} mm"
        far = f"{self.distance:.2f} m" if self.distance >= 1.0 else far
        parts = [far] if self.distance > NEAR else []
        parts += [f"{np.degrees(self.angle):.0f} degrees"] if self.angle > ALIGNED else []
        return (
            f"{self.task} cannot reach its waypoint {self.number} (t = {self.t:g} s): "
            f"it misses it by {' and '.join(parts)}"
        )


def missed_waypoints(
    scenario: schema.Scenario, setup: Setup, levels: list[list[Task]], q_start: Array
) -> tuple[Miss, ...]:
    """Return every waypoint that the robot, standing and within its limits, cannot get to.

    The tasks of the scenario in their order lead the robot from waypoint to waypoint, each held
    until it rests; obstacles, gaze and other contacts than the soles are left out.
    """
    stops: dict[float, list[tuple[str, int]]] = {}
    for name, number, t in _waypoints(scenario):
        stops.setdefault(t, []).append((name, number))
    q, misses = q_start, []
    for t in sorted(stops):
        tasks = _held(scenario, setup, levels, t)
        q = _settled(scenario, setup, tasks, q)
        kin = setup.robot.at(q)
        by_name = {task.name: task for level in tasks for task in level}
        for name, number in stops[t]:
            task = by_name.get(name)
            if task is None:
                continue
            error = task.error(kin, 0.0)
            distance, angle = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
            if distance > NEAR or angle > ALIGNED:
                misses.append(Miss(name, number, t, distance, angle))
    return tuple(misses)


def calmed(scenario: schema.Scenario, misses: Iterable[Miss]) -> schema.Scenario:
    """Return the scenario with what the file leaves open of ways out of reach: calm and slow."""
    tasks = dict(scenario.tasks)
    for name in {miss.task for miss in misses}:
        spec = tasks[name]
        if isinstance(spec, schema.FramePathSpec) and spec.calm is None:
            left = {key: value for key, value in CALM.items() if getattr(spec, key) is None}
            tasks[name] = spec.model_copy(update={**left, "calm": True})
    return scenario.model_copy(update={"tasks": tasks})


def postures_ahead(
    scenario: schema.Scenario, setup: Setup, levels: list[list[Task]], q_start: Array
) -> list[Array]:
    """Return the postures (nq,) that the reference comes by, one every `EVERY` seconds."""
    period, postures = scenario.control.period, []
    motion = MotionGenerator(
        setup.robot,
        levels,
        lambda: make_solver(scenario.control.solver),
        period,
        q_start,
        fades=build_fades(scenario),
        advise=False,
    )
    for k in range(round(scenario.duration / period)):
        motion.solve(k * period)
        motion.move_on()
        if k % round(EVERY / period) == 0:
            postures.append(motion.q_ref)
    return postures


def _waypoints(scenario: schema.Scenario) -> Iterator[tuple[str, int, float]]:
    """Yield task, number and time of each waypoint that the run comes to."""
    for name, task in scenario.tasks.items():
        waypoints: Iterable[schema.WaypointSpec | Waypoint] = ()
        if isinstance(task, schema.FramePathSpec):
            waypoints = slowed_way(task)[0]
        elif isinstance(task, schema.HandOnObjectSpec):
            waypoints = scenario.world.objects[task.object].waypoints
        for number, waypoint in enumerate(waypoints):
            begin, end = task.window or (0.0, np.inf)
            if task.enabled and waypoint.t <= scenario.duration and begin <= waypoint.t <= end:
                yield name, number, waypoint.t


def _held(
    scenario: schema.Scenario, setup: Setup, tasks: list[list[Task]], t: float
) -> list[list[Task]]:
    """Return the levels with every frame held where it is wanted at time `t` [s]."""
    contacts = ContactTask("contacts", setup.soles, rate=scenario.control.contact_rate)
    levels: list[list[Task]] = [[contacts]]
    for level in tasks[1:]:
        held: list[Task] = []
        for task in level:
            spec = scenario.tasks.get(task.name)
            window = None if spec is None else spec.window
            if window is not None and not window[0] <= t <= window[1]:
                continue
            if isinstance(task, FramePoseTask):
                wanted = FixedPose(task.target.at(t).T_world_target)
                rate = min(task.rate, 0.5 / STEP)
                held.append(FramePoseTask(task.name, task.frame, wanted, rate=rate))
            elif not isinstance(task, LEFT_OUT):
                held.append(task)
        if held:
            levels.append(held)
    return levels


def _settled(scenario: schema.Scenario, setup: Setup, levels: list[list[Task]], q: Array) -> Array:
    """Return the configuration (nq,) in which the tasks leave the robot."""
    solver = make_solver(scenario.control.solver)
    motion = MotionGenerator(setup.robot, levels, solver, STEP, q, advise=False)
    for _ in range(MOST_STEPS):
        if np.abs(motion.step(0.0).v_ref).max() < REST:
            break
    return motion.q_ref
