"""A foot that is dragged: the weight goes over the other feet, it lifts, and is put down again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum

import numpy as np
import pinocchio as pin

from equipoise.contacts import SoleContact, SupportPolygon
from equipoise.kinematics import Kinematics
from equipoise.motion.levels import polygon_of
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import (
    ComPolygonTask,
    ComTask,
    FramePoseTask,
    JointLimitsTask,
    Task,
)
from equipoise.viewer.playing.foot_places import Foot, centre_of, moved, place_of
from equipoise.viewer.playing.lead import Lead, Pace
from equipoise.walking.pieces import derivative, move, value

BEGINS = 0.02  # [m] from which on a dragged foot is lifted
CLEAR, LOW = 0.04, 0.015  # [m] above its floor: how it is carried, and as good as put down
NEAR = 0.01  # [m] beside the place where it is put down
SINK, DEEPEST = 0.03, 0.03  # [m/s] at which it looks for the floor, and [m] how far under it
TOUCH = 0.03  # share of the weight that tells the floor
OVERSHOOT = 0.008  # [m] by which the zero-moment point of a shift may pass its goal
REST = 0.2  # [s] of rest behind a shift
APART = 0.75  # of the distance at the start that feet beside each other keep
SHARE, APPROACH = 0.5, 1.5  # of the support for the centre of mass, [1/s] it nears the edge with
MOVING = 0.01  # [m/s] of a foot, from which on it moves
SLOW = Pace(speed=0.12, acceleration=0.4, near=2.5, joints=0.6)


class Phase(Enum):
    """Who carries; the value is a sentence about a foot."""

    STANDS = ""
    SHIFTS = "The weight goes over the other feet, so that {} can lift."
    AIR = "{} is in the air; drag it to the floor to put it down."
    LOOKS = "{} looks for the floor."
    RETURNS = "{} is down; the weight comes back."


class Footing:
    """Leads the centre of mass and one foot at a time; it says who carries.

    `feet` are the contacts as they stand now, `targets` (3,) [m] by name where each was dragged.
    `advance` leads on; where it tells so, the levels are others (`rebuild`), or the supports.
    """

    def __init__(self, robot: Robot, feet: Sequence[Foot], speeds: Mapping[str, float]) -> None:
        self.robot, self._speeds = robot, speeds
        self.feet = {foot.name: foot for foot in feet}
        self.targets = {foot.name: place_of(foot).translation.copy() for foot in feet}
        self.at_start = {name: place.copy() for name, place in self.targets.items()}
        self.phase, self.foot = Phase.STANDS, ""
        self._since, self._powers, self._duration = 0.0, np.zeros((6, 3)), 0.0
        self.stepped = False  # whether a foot was put down elsewhere
        self._weight = 9.81 * robot.mass
        self._anchor = pin.SE3.Identity()
        self._lead: Lead | None = None
        self._com: ComTask | None = None
        self._task: FramePoseTask | None = None
        self.lifts = len(feet) > 1 and all(isinstance(foot, SoleContact) for foot in feet)

    @property
    def carrying(self) -> tuple[str, ...]:
        """The names of the feet that carry."""
        air = self.phase in (Phase.AIR, Phase.LOOKS)
        return tuple(name for name in self.feet if not (air and name == self.foot))

    @property
    def moves(self) -> bool:
        """Whether weight or foot is on its way, so that hands may not reach yet what they will."""
        if self.phase in (Phase.STANDS, Phase.AIR):
            return self.phase is Phase.AIR and bool(np.abs(self._velocity()).max() > MOVING)
        return True

    @property
    def short(self) -> bool:
        """Whether the foot in the air could not follow for a while."""
        return self.phase is Phase.AIR and self._lead is not None and self._lead.waited > 0.0

    @property
    def sentence(self) -> str:
        """What is done with a foot; nothing where all stand."""
        waits = [n for n in self.feet if n != self.foot and self._off(n) > BEGINS]
        said = self.phase.value.format(self.foot)
        if self.phase is not Phase.STANDS and waits:
            said += f" {' and '.join(waits)} must wait: one foot at a time."
        return said

    def levels(self, kin: Kinematics) -> list[list[Task]]:
        """Return what comes before the hands: limits, balance, and the foot that is dragged.

        The reference is at `kin`.
        """
        limits: list[Task] = [JointLimitsTask("limits", self.robot, rate=5.0, speeds=self._speeds)]
        if self.phase is Phase.STANDS:
            polygon = _shrunk(polygon_of(tuple(self.feet.values())), kin.p_world_com)
            balance = ComPolygonTask("balance", polygon, margin=0.0, rate=APPROACH)
            return [[*limits, balance]]
        T = kin.placement(self.feet[self.foot].frame)
        p = kin.p_world_com
        self._com = ComTask("balance", np.array(p), axes=("x", "y"))
        self._task = FramePoseTask(self.foot, self.feet[self.foot].frame, T)
        return [limits, [self._com], [self._task]]

    def drag(self, name: str, place: Array) -> None:
        """Let a foot go to a place (3,) [m] in the world, one after the other."""
        self.targets[name] = np.array(place)
        if self._lead is not None:
            self._lead.waited = 0.0

    def advance(self, seconds: float, kin: Kinematics, loads: Mapping[str, float]) -> Phase:
        """Lead on for some time, the reference at `kin`; return the phase that is now.

        `loads` [N] by foot are what presses.
        """
        self._since += seconds
        if self.phase is Phase.STANDS:
            self._look_for_a_foot(kin)
        elif self.phase is Phase.SHIFTS:
            if self._shift():
                self._enter(Phase.AIR)
                self._lead = Lead(kin.placement(self.feet[self.foot].frame).translation, SLOW)
        elif self.phase is Phase.AIR:
            self._carry(seconds, kin)
        elif self.phase is Phase.LOOKS:
            self._sink(kin, loads[self.foot])
        elif self._shift():
            self._enter(Phase.STANDS)
        return self.phase

    def off(self, kin: Kinematics) -> float:
        """Return how far [m] the foot in the air is from where it was dragged."""
        there = kin.placement(self.feet[self.foot].frame).translation
        return float(np.linalg.norm(self._wanted() - there))

    def landed(self, T_world_foot: pin.SE3, kin: Kinematics) -> None:
        """Take note of where a foot stands now; the weight comes back."""
        foot, self.stepped = self.feet[self.foot], True
        self.feet[self.foot] = moved(foot, T_world_foot)
        self.targets[self.foot] = place_of(self.feet[self.foot]).translation.copy()
        self._enter(Phase.RETURNS)
        centres = [centre_of(foot)[:2] for foot in self.feet.values()]
        self._begin_shift(kin.p_world_com, np.mean(centres, axis=0))

    def _velocity(self) -> Array:
        return np.zeros(3) if self._lead is None else self._lead.velocity

    def _enter(self, phase: Phase) -> None:
        self.phase, self._since = phase, 0.0

    def _off(self, name: str) -> float:
        return float(np.linalg.norm(self.targets[name] - place_of(self.feet[name]).translation))

    def _look_for_a_foot(self, kin: Kinematics) -> None:
        for name in self.feet if self.lifts else ():
            if self._off(name) > BEGINS:
                self.foot = name
                self._enter(Phase.SHIFTS)
                self._begin_shift(kin.p_world_com, self._over_others(name))
                return

    def _begin_shift(self, p_world_com: Array, goal: Array) -> None:
        """Begin to move the centre of mass to a point (2,), as fast as the floor bears it."""
        way = float(np.linalg.norm(goal - p_world_com[:2]))
        floor = float(np.mean([centre_of(foot)[2] for foot in self.feet.values()]))
        height = float(p_world_com[2]) - floor
        self._duration = max(0.5, float(np.sqrt(5.77 * way * height / (9.81 * OVERSHOOT))))
        self._powers = move(np.array(p_world_com), np.array([*goal, p_world_com[2]]),
                            self._duration)  # fmt: skip

    def _over_others(self, name: str) -> Array:
        """Return where (2,) the centre of mass has to be so that a foot carries nothing."""
        others = [centre_of(foot)[:2] for other, foot in self.feet.items() if other != name]
        return np.asarray(np.mean(others, axis=0))

    def _shift(self) -> bool:
        """Lead the centre of mass; tell if it has come to rest."""
        assert self._com is not None
        s = min(self._since, self._duration)
        velocity = value(derivative(self._powers), s)
        self._com.target = _at(value(self._powers, s)), np.r_[velocity, 0, 0, 0]
        return self._since > self._duration + REST

    def _wanted(self) -> Array:
        """Return where the foot is to go (3,): not under the floor, nor through its neighbour."""
        foot, wanted = self.feet[self.foot], self.targets[self.foot].copy()
        stands = place_of(foot).translation
        wanted[2] = max(wanted[2], stands[2])
        T = place_of(next(one for name, one in self.feet.items() if name != self.foot))
        aside, before = T.actInv(wanted), T.actInv(stands)
        side = np.sign(before[1])
        aside[1] = side * max(side * aside[1], APART * abs(before[1]))
        return np.asarray(T.act(aside))

    def _carry(self, seconds: float, kin: Kinematics) -> None:
        """Lead the foot in the air: up, along, and down."""
        assert self._lead is not None
        assert self._task is not None
        floor = float(place_of(self.feet[self.foot]).translation[2])
        T, wanted = kin.placement(self.feet[self.foot].frame), self._wanted()
        here, goal = T.translation, wanted.copy()
        apart = float(np.linalg.norm((wanted - here)[:2]))
        low = float(wanted[2]) - floor < LOW
        if apart > NEAR:
            goal[2] = max(goal[2], floor + CLEAR)
            if here[2] < floor + 0.5 * CLEAR:
                goal[:2] = here[:2]
        self._lead.go_on(goal, here, seconds)
        if not self._lead.given_up:
            self._task.target = self._aim(self._lead.place - self._lead.velocity * seconds,
                                          self._lead.velocity)  # fmt: skip
        elif low:
            self._enter(Phase.LOOKS)
        if low and apart <= NEAR and here[2] < floor + LOW:
            self._enter(Phase.LOOKS)
        if self.phase is Phase.LOOKS:
            self._anchor = pin.SE3(place_of(self.feet[self.foot]).rotation, np.array(here))

    def _sink(self, kin: Kinematics, load: float) -> None:
        """Look for the floor below; `landed` is told when the foot presses."""
        assert self._task is not None
        place = self._anchor.translation - np.array([0.0, 0.0, SINK * self._since])
        floor = float(place_of(self.feet[self.foot]).translation[2])
        if place[2] < floor - DEEPEST:
            place[2] = floor - DEEPEST
        self._task.target = self._aim(place, np.array([0.0, 0.0, -SINK]))
        if load > TOUCH * self._weight:
            self._task.target = self._aim(place, np.zeros(3))
            self.landed(kin.placement(self.feet[self.foot].frame), kin)

    def _aim(self, place: Array, velocity: Array) -> tuple[pin.SE3, Array]:
        rotation = place_of(self.feet[self.foot]).rotation
        return pin.SE3(rotation, np.array(place)), np.r_[velocity, 0, 0, 0]


def _at(place: Array) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array(place))


def _shrunk(polygon: SupportPolygon, com: Array) -> SupportPolygon:
    """Return a polygon drawn together about the middle of its corners, and around where `com` is.

    What is left outside is for pushes, loads and what moving the body itself takes.
    """
    corners = np.asarray(polygon.vertices, dtype=float)
    middle = corners.mean(axis=0)
    return SupportPolygon.of_points(np.vstack((middle + SHARE * (corners - middle), com[:2])))
