"""A walk planned: which foot is lifted and put down when, and where the centre of mass is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_number
from equipoise.walking.centre import CentrePath, CentreState
from equipoise.walking.feet import (
    LEFT,
    RIGHT,
    Feet,
    Stance,
    require_stance,
    turn_between,
    with_foot,
    yaw_of,
)
from equipoise.walking.footsteps import Footstep
from equipoise.walking.pendulum import PendulumPath, ZmpMove
from equipoise.walking.quasi_static import CentreMove, QuasiStaticPath
from equipoise.walking.settings import WalkMode, WalkSettings
from equipoise.walking.swing import ACROSS
from equipoise.walking.tracks import Track

SHORTEST = 1e-6  # [s] of a phase that is worth a piece of the plan
PULL = 1.5  # times how far the divergent component is off, the zero-moment point that leads it back
INSIDE, CHECKED = 0.005, 101  # [m] in the sole that it has to be, and at how many moments


@dataclass(frozen=True)
class PlannedStep:
    """Step `number` (from 1) of a walk: lifted at `lift` [s], put down at `land` [s]."""

    number: int
    lift: float
    land: float
    footstep: Footstep

    @property
    def foot(self) -> int:
        """The foot that is put down."""
        return self.footstep.foot


@dataclass(frozen=True)
class WalkPlan:
    """Everything that is wanted of a walk over its own time, from a stance on.

    `centre` over the ground, `ground` [m] the height of what is stood on, `heading` [rad] of the
    body; `steps` are those still to come at its start.
    """

    stance: Stance
    steps: tuple[PlannedStep, ...]
    centre: CentrePath
    ground: Track
    heading: Track

    @property
    def end(self) -> float:
        """When it stands at rest again [s]."""
        return self.centre.end

    def swinging(self, t: float) -> PlannedStep | None:
        """Return the step whose foot is in the air at time `t` [s] by plan."""
        for one in self.steps:
            if one.lift <= t < one.land:
                return one
        return None

    def stance_before(self, step: PlannedStep) -> Stance:
        """Return where the feet stand when a step is lifted, by plan."""
        stance = self.stance
        for one in self.steps:
            if one.number < step.number:
                stance = with_foot(stance, one.foot, one.footstep.T_world_sole)
        return stance

    def stance_at(self, t: float) -> Stance:
        """Return where the feet stand, or are put down next, at time `t` [s] by plan."""
        stance = self.stance
        for one in self.steps:
            if one.lift <= t:
                stance = with_foot(stance, one.foot, one.footstep.T_world_sole)
        return stance


@dataclass(frozen=True)
class WalkPlanner:
    """Plans walks of a pair of feet, from a stand and from the middle of a walk."""

    feet: Feet
    settings: WalkSettings

    def begin(self, stance: Stance, steps: Sequence[Footstep], start: float = 0.0) -> WalkPlan:
        """Return the plan of a walk that begins at rest between two feet at `start` [s].

        Raises: `InputError`.
        """
        require_stance(self.feet, stance)
        start = real_number("the start of a walk", start)
        if not isinstance(steps, Sequence):
            raise InputError("a walk is a list of footsteps", given=type(steps).__name__)
        for step in steps:
            require_kind("each step of a walk", step, Footstep)
        timing, middle = self.settings.timing, self.feet.middle(stance)
        first = start + timing.settle + timing.shift
        planned = self._timed(steps, first, 1)
        ground, heading = self._follow(
            Track(float(middle.translation[2])), Track(yaw_of(middle)), stance, planned
        )
        still = middle.translation[:2].copy()
        nothing = np.zeros(2)
        at_rest = CentreState(still, nothing, nothing, still, still)
        moves = self._moves(stance, steps, still, fresh=True, wait=0.0)
        return WalkPlan(stance, planned, self._path(start, at_rest, moves), ground, heading)

    def go_on(
        self,
        plan: WalkPlan,
        t: float,
        stance: Stance,
        steps: Sequence[Footstep],
        number: int,
        wait: float = 0.0,
        state: CentreState | None = None,
    ) -> WalkPlan:
        """Return the plan from the touchdown at time `t` [s] of a plan on.

        `stance` is where the feet are now, `steps` are those that follow, of which `number` is the
        first; `wait` [s] is how much later the touchdown was planned, `state` where the centre of
        mass is if it is not where it was planned. Centre of mass, its velocity and acceleration,
        height and heading go on without a jump, so that an error of a landing is not carried along.
        """
        state = state or plan.centre.at(t)
        planned = self._timed(steps, t + wait + self.between, number)
        ground, heading = plan.ground.before(t), plan.heading.before(t)
        end = t + wait + self.settings.timing.double
        ground = ground.then(t, end, self._level(stance) - ground.final)
        here = yaw_of(self.feet.middle(stance))
        heading = heading.then(t, end, turn_between(heading.final, here))
        ground, heading = self._follow(ground, heading, stance, planned)
        moves = self._moves(stance, steps, state.zmp, fresh=False, wait=wait)
        return WalkPlan(stance, planned, self._path(t, state, moves), ground, heading)

    def catch(self, plan: WalkPlan, t: float, stance: Stance, step: PlannedStep) -> WalkPlan | None:
        """Return the plan that stands on one foot from time `t` [s] of a plan on, if any can.

        `step` puts the other foot down again. Position and velocity of the centre of mass go on,
        and it is led over the foot that carries; None where the zero-moment point would have to
        leave the sole for that.
        """
        foot, half = 1 - step.foot, 0.5 * (step.land - step.lift)
        state, goal = plan.centre.at(t), self.load_point(stance, foot)
        begin = state._replace(zmp=goal + PULL * (state.dcm - goal))
        moves = [ZmpMove(half, goal, True), ZmpMove(half, goal, True)]
        path = PendulumPath(self.settings.omega, t, begin, moves)
        sole = self.feet.support(stance, (foot,))
        times = np.linspace(t, step.land, CHECKED).tolist()
        if min(sole.margin(path.at(s).zmp) for s in times) < INSIDE:
            return None
        return WalkPlan(stance, (step,), path, plan.ground.before(t), plan.heading.before(t))

    @property
    def period(self) -> float:
        """From a touchdown to the next one [s]."""
        return self.settings.timing.single + self.between

    @property
    def between(self) -> float:
        """From a touchdown to the next lift [s]."""
        timing = self.settings.timing
        if self.settings.mode is WalkMode.SLOW:
            return timing.shift + timing.settle
        return timing.double

    def _timed(
        self, steps: Sequence[Footstep], lift: float, number: int
    ) -> tuple[PlannedStep, ...]:
        single, planned = self.settings.timing.single, []
        for k, step in enumerate(steps):
            planned.append(PlannedStep(number + k, lift, lift + single, step))
            lift += single + self.between
        return tuple(planned)

    def load_point(self, stance: Stance, foot: int) -> Array:
        """Return the point (2,) [m] over which a foot carries alone."""
        T = stance[foot]
        centre = self.feet.centre(foot, T)
        towards = -1.0 if foot == LEFT else 1.0
        point: Array = (centre + towards * self.settings.inward * T.rotation[:, 1])[:2]
        return point

    def _between_feet(self, stance: Stance) -> Array:
        middle: Array = self.feet.middle(stance).translation[:2].copy()
        return middle

    def _moves(
        self, stance: Stance, steps: Sequence[Footstep], zmp: Array, *, fresh: bool, wait: float
    ) -> list[ZmpMove]:
        """Return the moves of what is led over the ground."""
        timing, slow = self.settings.timing, self.settings.mode is WalkMode.SLOW
        moves: list[ZmpMove] = []

        def go(
            duration: float, goal: Array, bends: bool = False, pushed: Array | None = None
        ) -> None:
            if duration > SHORTEST:
                moves.append(ZmpMove(duration, goal, bends, pushed))

        def carry(goal: Array, T_from: pin.SE3, T_to: pin.SE3) -> None:
            """Stay at the goal while the other foot swings, whose leg pushes."""
            way = (T_to.translation - T_from.translation)[:2]
            begin, end = ACROSS
            go(begin * timing.single, goal)
            go((end - begin) * timing.single, goal, pushed=self.settings.leg * way)
            go((1.0 - end) * timing.single, goal)

        def over(goal: Array, duration: float, bends: bool) -> None:
            if slow:
                go(timing.shift, goal)
                go(timing.settle, goal)
            else:
                go(duration, goal, bends)

        if fresh and not slow:
            go(timing.settle, zmp, True)
        go(wait, zmp)
        duration, bends = (timing.shift, False) if fresh else (timing.double, True)
        for step in steps:
            goal = self.load_point(stance, 1 - step.foot)
            over(goal, duration, bends)
            carry(goal, stance[step.foot], step.T_world_sole)
            stance = with_foot(stance, step.foot, step.T_world_sole)
            duration, bends = timing.double, False
        middle = self._between_feet(stance)
        go(timing.shift, middle, bends)
        go(timing.settle, middle, True)
        return moves

    def _path(self, start: float, state: CentreState, moves: list[ZmpMove]) -> CentrePath:
        omega = self.settings.omega
        if self.settings.mode is WalkMode.SLOW:
            slow = [CentreMove(one.duration, one.goal) for one in moves]
            return QuasiStaticPath(omega, start, state.p, slow)
        return PendulumPath(omega, start, state, moves)

    def _follow(
        self, ground: Track, heading: Track, stance: Stance, steps: Sequence[PlannedStep]
    ) -> tuple[Track, Track]:
        """Return height and heading led from step to step."""
        timing = self.settings.timing
        slow = self.settings.mode is WalkMode.SLOW
        for one in steps:
            stance = with_foot(stance, one.foot, one.footstep.T_world_sole)
            turn = turn_between(heading.final, yaw_of(self.feet.middle(stance)))
            heading = heading.then(one.lift, one.land, turn)
            rise = self._level(stance) - ground.final
            begin = one.land if slow else one.land - 0.5 * timing.single
            ground = ground.then(begin, one.land + (timing.shift if slow else timing.double), rise)
        return ground, heading

    @staticmethod
    def _level(stance: Stance) -> float:
        return 0.5 * float(stance[LEFT].translation[2] + stance[RIGHT].translation[2])
