"""The task set that everybody is given: the tray on a robot, in three strict levels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.collision.scene import Pair
from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.scenarios import read_scenario
from equipoise.scenarios.schema import Scenario
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulation import Simulation
from equipoise.spatial import Array
from equipoise.tasks import FramePoseTask, Task

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
        return self.simulation.q_start

    @property
    def ticks(self) -> int:
        """The number of ticks of the scenario."""
        return self.simulation.steps

    def frame_tasks(self) -> dict[str, FramePoseTask]:
        """Return the tasks of hands and feet by name: what every peer is asked to follow."""
        found = {task.name: task for level in self.levels for task in level}
        return {name: found[name] for name in (*FEET, *HANDS)}

    def lam_ref(self, t: float) -> Array:
        """Return the wanted forces of the regulated rows at time `t` [s]."""
        held, wanted = self.simulation.setup.schedule.at(t).contacts, self.simulation.wanted_forces
        return np.array([force(t) for contact in held for force in wanted[contact.name]])


def make_problem(robot: str) -> Problem:
    """Return the problem on a robot that is named, or given by its path; takes some seconds.

    Raises: `NameNotFoundError`, `ScenarioError`, `RobotFileError`.
    """
    pairs = _single_pairs(read_scenario("tray", robot=robot))
    chosen = ", ".join(f"['{first}', '{second}']" for first, second in pairs)
    simulation = Simulation(
        read_scenario("tray", [f"tasks.obstacles.pairs=[{chosen}]"], robot=robot)
    )
    contacts, feet_and_com, *others = simulation.levels
    levels = ((*contacts, *feet_and_com), *(tuple(level) for level in others))
    scene = simulation.setup.scene
    return Problem(
        simulation.robot.name, simulation, levels, tuple(scene.pair(*pair) for pair in pairs)
    )


def _single_pairs(scenario: Scenario) -> list[tuple[str, str]]:
    """Return the first pairs of the scenario in which both bodies have one shape."""
    scene = build_setup(scenario).scene
    single = [
        (first, second)
        for first, second in scenario.tasks["obstacles"].pairs
        if len(scene.shapes_of(first)) == len(scene.shapes_of(second)) == 1
    ]
    if len(single) < PAIRS:
        raise InputError(
            f"the bench needs {PAIRS} collision pairs of one shape each",
            given=len(single),
            remedy="Give more links of the robot a collision shape",
        )
    return single[:PAIRS]
