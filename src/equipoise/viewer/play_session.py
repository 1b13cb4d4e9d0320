"""A robot whose hands can be dragged, without the page: targets, order, and what stands in the way.

What moves is the reference: the hierarchy with its contacts, limits and balance. No torque law and
no engine runs.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError, NameNotFoundError
from equipoise.hqp.explain import explain
from equipoise.motion import InverseKinematics
from equipoise.motion.generator import MotionStep
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.tasks import DampingTask, FrameAxesTask, PostureTask, Task, describe_rows

PERIOD = 0.01  # [s] of a step
ACCELERATIONS = 15.0  # [rad/s^2] that joints bear: what is out of reach is approached calmly
SPEED = 0.5  # [m/s] at which a hand is led to where it was dragged
ACCELERATION = 1.5  # [m/s^2] with which it is led
NEAR = 4.0  # [1/s] with which it comes to rest there
LEASH = 0.012  # [m] that it is led ahead of where it can be
PATIENCE = 0.5  # [s] after which a hand that cannot follow is left where it is
NAMED = 2  # bounds that a sentence names
# rows that only stand in the way where no speed of the joints would bring the hand on
STRETCHED = ("the rest of", "the acceleration limit of", "the speed limit of")
CALM = 0.03  # weight of rest against a hand, so that joints do not race near singular postures
SHORT = 1e-2  # [m] from which on a hand is worth an explanation


@dataclass(frozen=True)
class Reason:
    """Why hands are short: sentences, and the joints (of the model) whose limits are in the way."""

    sentences: tuple[str, ...] = ()
    joints: tuple[int, ...] = ()


class PlaySession:
    """Moves a robot that stands, or is fixed, so that its hands follow where they are dragged.

    `hands` are the frames that follow, by priority; `together` puts all on one level, where they
    share what they miss. Any thread may drag and reorder; it counts from the next step on.
    Raises: InputError for a robot without palms.
    """

    def __init__(self, robot: Robot) -> None:
        frames = [palm.frame for palm in robot.palms]
        if not frames:
            raise InputError(
                f"robot {robot.name} has no palms: there is nothing to drag",
                remedy="Name its palms in its YAML",
            )
        self.robot = robot
        self._lock = threading.RLock()
        self._found: dict[str, Reason] = {}  # why hands were given up
        kin = robot.at(robot.q_half_sitting)
        self.targets = {frame: np.array(kin.placement(frame).translation) for frame in frames}
        self.q = np.array(robot.q_half_sitting)
        self.order(frames)

    @property
    def all_hands(self) -> tuple[str, ...]:
        """Every hand, also those that hang free."""
        return tuple(self.targets)

    def drag(self, hand: str, place: Array) -> None:
        """Let a hand go to a place (3,) [m] in the world. Raises: NameNotFoundError, InputError."""
        place = real_vector("the place of a hand", place, 3)
        with self._lock:
            self._require(hand)
            self.targets[hand] = place
            self._waited = dict.fromkeys(self.targets, 0.0)
            self._found = {}

    def order(self, hands: Sequence[str], *, together: bool = False) -> None:
        """Let hands come in this order, highest first, or all share a level.

        Hands that are left out hang free. The robot goes on from where it is.
        Raises: NameNotFoundError.
        """
        with self._lock:
            for hand in hands:
                self._require(hand)
            self.hands, self.together = tuple(dict.fromkeys(hands)), together
            robot, kin = self.robot, self.robot.at(self.q)
            self._tasks = {
                hand: FrameAxesTask(hand, hand, kin.placement(hand)) for hand in self.hands
            }
            tasks = list(self._tasks.values())
            levels: list[list[Task]]
            levels = [[*tasks]] if together and tasks else [[task] for task in tasks]
            if (
                levels
            ):  # in the last level only: it leaves nothing to those below it but the posture
                levels[-1] = [*levels[-1], DampingTask("rest", robot).weighing(CALM)]
            posture = PostureTask("posture", robot, robot.q_half_sitting[robot.nq_base :])
            self._ik = InverseKinematics(
                robot, [*levels, posture], self.q, period=PERIOD, accelerations=ACCELERATIONS
            )
            self._led = {hand: np.array(kin.placement(hand).translation) for hand in self.hands}
            self._velocity = {hand: np.zeros(3) for hand in self.hands}
            self._step: MotionStep | None = None
            self._waited = dict.fromkeys(self.targets, 0.0)  # [s] that each could not follow
            self._found = {}

    def run(self, seconds: float) -> Array:
        """Go on for some time, at least a step; return the configuration (nq,)."""
        with self._lock:
            for _ in range(max(1, round(seconds / PERIOD))):
                self._lead(PERIOD)
                self._step = self._ik.step()
                self.q = np.array(self._ik.motion.q_ref)
            return self.q

    def off(self, hand: str) -> float:
        """Return how far [m] a hand is from where it was dragged. Raises: NameNotFoundError."""
        with self._lock:
            self._require(hand)
            there = self.robot.at(self.q).placement(hand).translation
            return float(np.linalg.norm(self.targets[hand] - there))

    def reason(self) -> Reason:
        """Say what stops the hands that are short, after a `run`; nothing if none is."""
        with self._lock:
            late = [h for h in self.hands if h not in self._found and self._waited[h] > 0.0]
            short = [hand for hand in late if self.off(hand) > SHORT]
            found = [*self._found.values(), *([self._find_reason(short)] if short else [])]
            joints = dict.fromkeys(joint for one in found for joint in one.joints)
            return Reason(tuple(s for one in found for s in one.sentences), tuple(joints))

    def _find_reason(self, hands: Sequence[str]) -> Reason:
        """Ask the last step what stands in the way of hands."""
        if self._step is None:
            return Reason()
        hierarchy, v = self._step.hierarchy, self._step.solution.v
        tasks = [task for level in self._ik.motion.levels for task in level]
        said = explain(hierarchy, v, describe_rows(tasks, hierarchy), tasks=hands)
        names, joints, sentences = list(self.robot.model.names), [], []
        for one in said.shortfalls:
            told = [b for b in one.breaking if not b.phrase.startswith(STRETCHED)][:NAMED]
            by = " and ".join(dict.fromkeys(re.sub(r"edge\d+", "edge", b.phrase) for b in told))
            why = f"stopped by {by}" if by else "it is stretched out and reaches no further"
            sentences.append(f"{one.task} is {100 * self.off(one.task):.0f} cm short: {why}.")
            for blocker in one.breaking[:NAMED]:
                label = blocker.name.split("/", 1)[-1]
                if label in names:
                    joints.append(names.index(label))
        return Reason(tuple(sentences), tuple(dict.fromkeys(joints)))

    def _give_up(self, hand: str, place: Array) -> None:
        """Let a hand that cannot come nearer rest where it is, and remember why.

        At its bound the best answer swings from one step to the next; at rest it does not.
        """
        if hand not in self._found:
            self._found[hand] = self._find_reason([hand])
        self._led[hand] = np.array(place)

    def _require(self, hand: str) -> None:
        if hand not in self.targets:
            raise NameNotFoundError("hand", hand, self.targets)

    def _lead(self, seconds: float) -> None:
        """Lead the hands on towards their targets, as fast as a hand should go.

        A hand that cannot follow is not led further away than `LEASH`.
        """
        kin = self.robot.at(self.q)
        for hand, task in self._tasks.items():
            way = self.targets[hand] - self._led[hand]
            wanted = way * min(SPEED / max(float(np.linalg.norm(way)), 1e-9), NEAR)
            ahead = self._led[hand] - kin.placement(hand).translation
            far = float(np.linalg.norm(ahead))
            if far > LEASH:  # it cannot follow: wait for it there, at rest
                self._led[hand] = self._led[hand] - ahead * (1.0 - LEASH / far)
                self._velocity[hand], wanted = np.zeros(3), np.zeros(3)
                self._waited[hand] += seconds
                if self._waited[hand] > PATIENCE:
                    self._give_up(hand, kin.placement(hand).translation)
            if self._waited[hand] > PATIENCE:
                wanted = np.zeros(3)
            change = wanted - self._velocity[hand]
            most = ACCELERATION * seconds / max(float(np.linalg.norm(change)), 1e-9)
            velocity = self._velocity[hand] + change * min(1.0, most)
            task.target = pin.SE3(np.eye(3), self._led[hand]), np.r_[velocity, np.zeros(3)]
            self._led[hand] = self._led[hand] + velocity * seconds
            self._velocity[hand] = velocity
