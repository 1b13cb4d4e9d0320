"""Which waypoints the robot cannot get to, and by how much it misses each: told before it moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

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
from equipoise.trajectories import FixedPose

STEP = 0.02  # [s] of an Euler step; the rates of the tasks times it stay below 1
MOST_STEPS = 250  # of the way to a waypoint
EVERY = 0.04  # [s] between postures that are looked at
REST = 1e-3  # [m/s, rad/s] below which the robot has come to rest
# what bounds a way that is out of reach, where its file says nothing
CALM = {"speed": 0.5, "acceleration": 0.7, "turn": 1.0, "turn_acceleration": 1.4}
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


@dataclass(frozen=True)
class Outlook:
    """What is found of a run's ways before it: the `misses`, and by name which ways are `calm`.

    `ahead` are the postures (nq,) that the reference of calm ways will come by.
    """

    misses: tuple[Miss, ...] = ()
    calm: tuple[str, ...] = ()
    ahead: tuple[Array, ...] = ()


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


def calmed(scenario: schema.Scenario, names: Iterable[str]) -> schema.Scenario:
    """Return the scenario with what the file leaves open of some ways: they are calm and slow."""
    tasks = dict(scenario.tasks)
    for name in names:
        spec = tasks[name]
        if isinstance(spec, schema.FramePathSpec) and spec.calm is None:
            left = {key: value for key, value in CALM.items() if getattr(spec, key) is None}
            tasks[name] = spec.model_copy(update={**left, "calm": True})
    return scenario.model_copy(update={"tasks": tasks})


@dataclass(frozen=True)
class Ahead:
    """The reference of a whole run: postures (nq,) and velocities (nv,), one every `EVERY` [s]."""

    postures: list[Array]
    velocities: list[Array]

    def room(self, setup: Setup) -> float:
        """Return how far [m] inside the soles the nominal robot's zero-moment point stays."""
        if setup.polygon is None:
            return np.inf
        model, polygon = setup.robot.model, setup.polygon
        context, least = model.createData(), np.inf
        for k in range(1, len(self.postures) - 1):
            q, v = self.postures[k], self.velocities[k]
            a = (self.velocities[k + 1] - self.velocities[k - 1]) / (2.0 * EVERY)
            f = pin.XYZQUATToSE3(q[:7]).act(pin.Force(pin.rnea(model, context, q, v, a)[:6]))
            point = np.array([-f.angular[1], f.angular[0]]) / f.linear[2]
            least = min(least, float((polygon.offsets - polygon.normals @ point).min()))
        return least


def look_ahead(
    scenario: schema.Scenario, setup: Setup, levels: list[list[Task]], q_start: Array
) -> Ahead:
    """Return where the reference will come by, on a robot that follows it."""
    period, ahead = scenario.control.period, Ahead([], [])
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
        step = motion.step(k * period)
        if k % round(EVERY / period) == 0:
            ahead.postures.append(step.q_ref)
            ahead.velocities.append(step.v_ref)
    return ahead


def ways_of(scenario: schema.Scenario, setup: Setup) -> list[str]:
    """Return the ways of frames that a robot follows which nothing but its soles holds."""
    if scenario.walk is not None or not all(one.supporting for one in setup.contacts.contacts):
        return []
    if setup.polygon is None:
        return []
    return [
        name
        for name, spec in scenario.tasks.items()
        if isinstance(spec, schema.FramePathSpec) and spec.enabled and spec.calm is None
    ]


def _waypoints(scenario: schema.Scenario) -> Iterator[tuple[str, int, float]]:
    """Yield task, number and time of each waypoint that the run comes to."""
    for name, task in scenario.tasks.items():
        waypoints: Sequence[schema.WaypointSpec] = ()
        times: list[float] = []
        if isinstance(task, schema.FramePathSpec):
            waypoints, times = task.waypoints, [one.t for one in slowed_way(task)[0]]
        elif isinstance(task, schema.HandOnObjectSpec):
            waypoints = scenario.world.objects[task.object].waypoints
            times = [waypoint.t for waypoint in waypoints]
        for number, (waypoint, t) in enumerate(zip(waypoints, times, strict=True)):
            begin, end = task.window or (0.0, np.inf)
            if task.enabled and waypoint.t <= scenario.duration and begin <= waypoint.t <= end:
                yield name, number, t


def _held(
    scenario: schema.Scenario, setup: Setup, tasks: list[list[Task]], t: float
) -> list[list[Task]]:
    """Return the levels with every frame held where it is wanted at time `t` [s]."""
    contacts = ContactTask("contacts", setup.soles, rate=scenario.control.contact_rate)
    levels: list[list[Task]] = [[contacts]]
    for level in tasks[1:]:
        held: list[Task] = []
        for task in level:
            spec = scenario.tasks.get(task.name)  # None: one of the walk, which begins there
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
