"""The task set that everybody is given: the tray on a robot, in three strict levels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from equipoise.collision.scene import Pair
from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.scenarios import read_scenario
from equipoise.scenarios.schema import AvoidanceSpec, Scenario
from equipoise.simulation.build.assemble import control_settings
from equipoise.simulation.build.forces import wanted_forces
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulation import Simulation
from equipoise.spatial import Array
from equipoise.tasks import AvoidanceTask, FramePoseTask, Task
from equipoise.wbc import WholeBodyController

PAIRS = 8
HANDS, FEET = ("left_hand", "right_hand"), ("left_foot", "right_foot")


@dataclass(frozen=True, eq=False)
class Problem:
    """A scenario made ready, and its tasks regrouped for the bench.

    `levels`: contacts, feet and centre of mass; hands and joint limits; gaze and obstacles; and
    the posture, which takes what is left. `pairs` are `PAIRS` pairs of one shape each.
    """

    name: str
    simulation: Simulation
    levels: tuple[tuple[Task, ...], ...]
    pairs: tuple[Pair, ...]
    all_pairs: tuple[Pair, ...]

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.simulation.robot

    @property
    def dt(self) -> float:
        """The control period [s]."""
        return self.simulation.dt

    @property
    def q_start(self) -> Array:
        """The posture (nq,) at time 0."""
        return self.simulation.assembly.q_start

    @property
    def ticks(self) -> int:
        """The number of ticks of the scenario."""
        return self.simulation.steps

    def levels_with(self, pairs: Sequence[Pair]) -> tuple[tuple[Task, ...], ...]:
        """Return the levels with other pairs kept apart."""

        def changed(task: Task) -> Task:
            if not isinstance(task, AvoidanceTask):
                return task
            return AvoidanceTask(
                task.name, task.scene, pairs,
                influence=task.influence, security=task.security, damping=task.damping,
            )  # fmt: skip

        return tuple(tuple(changed(task) for task in level) for level in self.levels)

    def frame_tasks(self) -> dict[str, FramePoseTask]:
        """Return the tasks of hands and feet by name: what every peer is asked to follow."""
        tasks = [task for level in self.levels for task in level]
        found = {task.name: task for task in tasks if isinstance(task, FramePoseTask)}
        return {name: found[name] for name in (*FEET, *HANDS)}

    def make_controller(
        self, levels: Sequence[Sequence[Task]] | None = None
    ) -> WholeBodyController:
        """Return the whole controller on the tasks of the bench, or on other `levels`."""
        scenario, assembly = self.simulation.scenario, self.simulation.assembly
        return WholeBodyController(
            self.robot,
            self.levels if levels is None else levels,
            self.simulation.setup.schedule,
            control_settings(scenario, assembly.advice),
            self.q_start,
            wanted_forces=wanted_forces(scenario),
        )


def make_problem(robot: str) -> Problem:
    """Return the problem on a robot that is named, or given by its path; takes some seconds.

    Raises: `NameNotFoundError`, `ScenarioError`, `RobotFileError`.
    """
    whole = read_scenario("tray", robot=robot)
    pairs = _single_pairs(whole)
    chosen = ", ".join(f"['{first}', '{second}']" for first, second in pairs)
    simulation = Simulation(
        read_scenario("tray", [f"tasks.obstacles.pairs=[{chosen}]"], robot=robot)
    )
    contacts, feet_and_com, *others = simulation.levels
    levels = ((*contacts, *feet_and_com), *(tuple(level) for level in others))
    scene = simulation.setup.scene
    return Problem(
        simulation.robot.name,
        simulation,
        levels,
        tuple(scene.pair(*pair) for pair in pairs),
        tuple(scene.pair(*pair) for pair in _pairs_of(whole)),
    )


def _pairs_of(scenario: Scenario) -> list[tuple[str, str]]:
    """Return the pairs that the scenario keeps apart."""
    obstacles = scenario.tasks["obstacles"]
    assert isinstance(obstacles, AvoidanceSpec)
    return [(first, second) for first, second in obstacles.pairs]


def _single_pairs(scenario: Scenario) -> list[tuple[str, str]]:
    """Return the first pairs of the scenario in which both bodies have one shape."""
    scene = build_setup(scenario).scene
    single = [
        (first, second)
        for first, second in _pairs_of(scenario)
        if len(scene.shapes_of(first)) == len(scene.shapes_of(second)) == 1
    ]
    if len(single) < PAIRS:
        raise InputError(
            f"the bench needs {PAIRS} collision pairs of one shape each",
            given=len(single),
            remedy="Give more links of the robot a collision shape",
        )
    return single[:PAIRS]
