"""What can be dragged and in which order: a session of `play` without its page."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots import Robot
from equipoise.robots.guess import ends_of_arms
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.tasks import DampingTask, FrameAxesTask, GazeTask, PostureTask, Task
from equipoise.viewer.base_link import base_link
from equipoise.viewer.playing.footing import Footing
from equipoise.viewer.playing.lead import Lead, Pace
from equipoise.viewer.playing.reason import Reason, Solved, find_reason, joined

ACCELERATIONS = 15.0  # [rad/s^2] that joints bear: what is out of reach is approached calmly
CALM = 0.03  # weight of rest against a hand, so that joints do not race near singular postures
GLANCE = 0.3  # weight of the gaze [rad/s] against a hand [m/s]
SHORT = 1e-2  # [m] from which on a hand is worth an explanation
SEEN = 1.5  # [m] ahead of the camera stands what is looked at
GAZE = "gaze"


class PlaySession(ABC):
    """Moves a robot that stands, or is fixed, so that its hands follow where they are dragged.

    `hands` are the frames that follow, by priority; `together` puts all on one level, where they
    share what they miss. `targets` (3,) [m] are where each was dragged, `q` (nq,) is where the
    robot is. Any thread may drag and reorder; it counts from the next step on.
    Raises: InputError for a robot of which nothing can be dragged.
    """

    def __init__(self, robot: Robot, pace: Pace) -> None:
        self.robot, self._pace = robot, pace
        self._lock = threading.RLock()
        self.footing: Footing | None = None  # who leads its feet
        self._found: dict[str, Reason] = {}  # why hands were given up
        self.q = np.array(robot.q_half_sitting)
        kin = robot.at(self.q)
        frames = frames_to_drag(robot)
        self.targets = {frame: np.array(kin.placement(frame).translation) for frame in frames}
        self.seen = _ahead(robot, self.q)
        self._looks = False  # until somebody says where to
        self._gaze: GazeTask | None = None
        self.order(frames)

    @property
    def all_hands(self) -> tuple[str, ...]:
        """Every hand, also those that hang free."""
        return tuple(self.targets)

    @property
    def feet(self) -> dict[str, Array]:
        """Where each foot was dragged (3,) [m], by name; none if they are points."""
        return {} if self.footing is None or not self.footing.lifts else self.footing.targets

    @property
    def feet_at_start(self) -> dict[str, Array]:
        """Where these feet stood at first (3,) [m]."""
        return {} if self.footing is None else self.footing.at_start

    @property
    def why_feet_stay(self) -> str:
        """Why no foot can be dragged, in words."""
        return "lifting one takes the torque law"

    def drag_foot(self, name: str, place: Array) -> None:
        """Let a foot go to a place (3,) [m] in the world: the weight goes over the others first.

        Raises: NameNotFoundError, InputError.
        """
        place = real_vector("the place of a foot", place, 3)
        with self._lock:
            if name not in self.feet or self.footing is None:
                raise NameNotFoundError("foot that can be dragged", name, self.feet)
            self.footing.drag(name, place)

    def drag(self, hand: str, place: Array) -> None:
        """Let a hand go to a place (3,) [m] in the world. Raises: NameNotFoundError, InputError."""
        place = real_vector("the place of a hand", place, 3)
        with self._lock:
            self._require(hand)
            self.targets[hand] = place
            self._try_again()

    def look(self, place: Array) -> None:
        """Let the robot look at a place (3,) [m] in the world; before, its head is free.

        Raises: InputError for a robot without a camera.
        """
        place = real_vector("the place to look at", place, 3)
        with self._lock:
            if self.seen is None:
                raise InputError(
                    f"robot {self.robot.name} has no camera", remedy="Name its camera in its YAML"
                )
            self.seen = place
            if self._gaze is None:
                self._looks = True
                self.order(self.hands, together=self.together)
            else:
                self._gaze.target = _at(place)

    def order(self, hands: Sequence[str], *, together: bool = False) -> None:
        """Let hands come in this order, highest first, or all share a level.

        Hands that are left out hang free. The robot goes on from where it is.
        Raises: NameNotFoundError.
        """
        with self._lock:
            for hand in hands:
                self._require(hand)
            self.hands, self.together = tuple(dict.fromkeys(hands)), together
            robot, kin = self.robot, self.robot.at(self._reference())
            self._tasks = {
                hand: FrameAxesTask(hand, hand, _at(kin.placement(hand).translation))
                for hand in self.hands
            }
            tasks: list[Task] = [*self._tasks.values()]
            levels = [tasks] if together and tasks else [[task] for task in tasks]
            last: list[Task] = levels.pop() if levels else []
            if self._looks and robot.camera is not None and self.seen is not None:
                self._gaze = GazeTask(GAZE, robot.camera, _at(self.seen)).weighing(GLANCE)
                last = [*last, self._gaze]
            # in the last level only: it leaves nothing to those below it but the posture
            levels.append([*last, DampingTask("rest", robot).weighing(CALM)])
            levels.append([PostureTask("posture", robot, self._rest())])
            self._take(levels)
            self._leads = {
                hand: Lead(kin.placement(hand).translation, self._pace) for hand in self.hands
            }
            self._found = {}

    def off(self, hand: str) -> float:
        """Return how far [m] a hand is from where it was dragged. Raises: NameNotFoundError."""
        with self._lock:
            self._require(hand)
            there = self.robot.at(self.q).placement(hand).translation
            return float(np.linalg.norm(self.targets[hand] - there))

    def reason(self) -> Reason:
        """Say what stops the hands that are short, after a `run`; nothing if none is."""
        with self._lock:
            late = [h for h in self.hands if h not in self._found and self._leads[h].waited > 0.0]
            short = [hand for hand in late if self.off(hand) > SHORT]
            return joined([*self._found.values(), *([self._find(short)] if short else [])])

    def _find(self, hands: Sequence[str]) -> Reason:
        """Ask the last step what stands in the way of hands."""
        solved = self._solved()
        if solved is None:
            return Reason()
        return find_reason(self.robot, solved, {hand: self.off(hand) for hand in hands})

    def _try_again(self) -> None:
        """Lead hands again that were given up."""
        self._found = {}
        for lead in self._leads.values():
            lead.waited = 0.0

    def _require(self, hand: str) -> None:
        if hand not in self.targets:
            raise NameNotFoundError("hand", hand, self.targets)

    def _lead(self, seconds: float) -> None:
        """Lead the hands on towards their targets, as fast as a hand should go."""
        kin, rates = self.robot.at(self._reference()), self._joint_rates()
        for hand, task in self._tasks.items():
            lead, there = self._leads[hand], kin.placement(hand).translation
            own = rates[list(self.robot.joints_between(hand))]
            lead.go_on(self.targets[hand], there, seconds, float(np.abs(own).max(initial=0.0)))
            if lead.given_up and hand not in self._found:
                far = self.off(hand) > SHORT
                self._found[hand] = self._find([hand]) if far else Reason()
            task.target = _at(lead.place - lead.velocity * seconds), np.r_[lead.velocity, 0, 0, 0]

    @abstractmethod
    def run(self, seconds: float) -> Array:
        """Go on for some time, at least a step; return the configuration (nq,)."""

    @abstractmethod
    def _reference(self) -> Array:
        """Return the configuration (nq,) that the hierarchy has come to."""

    def _rest(self) -> Array:
        """Return the joints (na,) that it comes back to."""
        return self.robot.q_half_sitting[self.robot.nq_base :]

    def _joint_rates(self) -> Array:
        """Return how fast (na,) the joints of the reference go, where they are to be spared."""
        return np.zeros(self.robot.na)

    @abstractmethod
    def _take(self, levels: list[list[Task]]) -> None:
        """Follow these levels from the next step on."""

    @abstractmethod
    def _solved(self) -> Solved | None:
        """Return the hierarchy of the last step and its answer."""


def frames_to_drag(robot: Robot) -> tuple[str, ...]:
    """Return the palms; without any the ends of the arms, and of a robot that walks its trunk.

    Raises: InputError where there is neither.
    """
    palms = tuple(palm.frame for palm in robot.palms)
    if palms:
        return palms
    found = (base_link(robot),) if robot.nv_base else ends_of_arms(robot)
    if not found:
        raise InputError(
            f"robot {robot.name} has no palms: there is nothing to drag",
            remedy="Name its palms in its YAML",
        )
    return found


def _ahead(robot: Robot, q: Array) -> Array | None:
    """Return the place (3,) [m] that the camera looks at first, None without one."""
    if robot.camera is None:
        return None
    T = robot.at(q).placement(robot.camera)
    return np.array(T.act(np.array([SEEN, 0.0, 0.0])))


def _at(place: Array) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array(place))
