"""The phases of a walk as they happen: lift, swing, touchdown when the ground is there, and on."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from equipoise.walking.balance import BalanceFeedback
from equipoise.walking.capture import StepAside
from equipoise.walking.clock import WalkClock
from equipoise.walking.events import WalkEvent
from equipoise.walking.feet import LEFT, RIGHT, Stance, level_pose, with_foot, yaw_of
from equipoise.walking.foot_path import FootPath, Standing
from equipoise.walking.footsteps import Footstep, closing_step, moved_by
from equipoise.walking.landing import Glide, Probe
from equipoise.walking.plan import PlannedStep, WalkPlan, WalkPlanner
from equipoise.walking.settings import TouchSettings
from equipoise.walking.swing import Swing
from equipoise.walking.targets import WalkTargets

BOTH = (LEFT, RIGHT)
TOO_LATE = 0.04  # [s] before its planned touchdown from which on a foot is not let go again
OFF = 0.15  # of the load of a touchdown (0.45 % of the weight; it gets 1 %), below which it is off
SOON = 0.5  # [s] before its lift from which on a foot may be light
CATCH = 1.4  # [s] in which a foot that was lost is put down again
LATE = 0.01  # [s] behind its plan at which a touchdown is told to be late


@dataclass
class Walker:
    """Leads the targets of a walk, tick by tick, from what the feet feel.

    `advance` once a tick says which feet carry. A touchdown is where the ground is: the plan goes
    on from where the foot stands, so that errors of landings do not add up. `stop` and `walk_on`
    take effect with the next touchdown; what was said last counts. With a `balance` whose
    settings allow it a foot in the air is put where it catches the divergent component; those that
    follow are put as far aside. `put_down` counts the steps that ended on the ground.
    """

    planner: WalkPlanner
    plan: WalkPlan
    touch: TouchSettings
    targets: WalkTargets
    clock: WalkClock = field(default_factory=WalkClock)
    balance: BalanceFeedback | None = None
    supports: tuple[int, ...] = BOTH
    events: list[WalkEvent] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.stance: Stance = self.plan.stance
        feet = self.planner.feet
        middle = feet.middle(self.stance)
        own = [middle.actInv(T) for T in self.stance]
        self._beside = own[RIGHT].actInv(own[LEFT]), own[LEFT].actInv(own[RIGHT])
        self._paths: list[FootPath] = [Standing(T) for T in self.stance]
        # a foot that is late goes by the time of the room, which is ahead of the plan's clock [s]
        self._searches, self._ahead = [False, False], [0.0, 0.0]
        self._swing: PlannedStep | None = None
        self._aside = StepAside(self.balance.settings.step if self.balance is not None else 0.0)
        self._landed: PlannedStep | None = None  # earlier than planned, so that it may bounce
        self._off = 0.0  # [s] without load
        self._left = [one.footstep for one in self.plan.steps]  # footsteps not yet begun
        self._number = 1  # of the next step
        self.put_down = self._before = 0  # steps, each once; those of walks before
        self._wanted: list[Footstep] | None = None
        self._stops = self._stood = self._told = False
        self._heading = self.plan.heading.at(self.clock.t)[0]
        self._upright = [
            (led, led.at(0.0).T_world_target.rotation.T.tolist())
            for led in self.targets.upright.values()
        ]
        self._last_heading = self._heading
        centre, ground = self.plan.centre.at(self.clock.t), self.plan.ground.at(self.clock.t)
        self._start = np.array([*centre.p, ground[0]])
        # what was written last and is still true: paths at their end, heading and its rate
        self._at_rest: list[FootPath | None] = [None, None]
        self._turned = (math.nan, math.nan)
        self._write()

    # -- what one may ask -----------------------------------------------------------------------

    @property
    def swinging(self) -> PlannedStep | None:
        """The step in the air."""
        return self._swing

    @property
    def stands(self) -> bool:
        """Whether both feet carry and nothing is to come."""
        return self._swing is None and not self._left and self.clock.t >= self.plan.end

    @property
    def remaining(self) -> int:
        """How many steps are still to come, that in the air not counted."""
        return len(self._left)

    def lifts_soon(self, foot: int) -> bool:
        """Return whether a foot that stands is to be lifted before long by the plan."""
        following = next((one for one in self.plan.steps if one.number == self._number), None)
        if following is None or not self._left or following.foot != foot:
            return False
        return following.lift - self.clock.t < SOON

    def stop(self) -> None:
        """Put the feet side by side at the next touchdown, and stand."""
        self._stops, self._wanted = True, None

    def walk_on(self, steps: Sequence[Footstep]) -> None:
        """Let these steps follow the next touchdown, instead of those planned; or begin now."""
        self._stops, self._wanted = False, list(steps)

    def lose(self, t: float, foot: int) -> bool:
        """Stand on the other foot, since this one lost its ground, and put it down again.

        Returns whether that can be: if the centre of mass is too far from the other foot, or that
        one is in the air, nothing changes.
        """
        if self.supports != BOTH:
            return False
        s, shape = self.clock.t, self.planner.settings.swing
        here = self._paths[foot].at(self._foot_time(foot)[0]).T_world_sole
        step = PlannedStep(self._number - 1, s, s + CATCH, Footstep(foot, here))
        plan = self.planner.catch(self.plan, s, self.stance, step)
        if plan is None:
            return False
        self.plan, self._swing, self.supports = plan, step, (1 - foot,)
        self._lead(foot, Swing(here, here, step.lift, step.land, shape))
        self._landed, self._told = None, False
        self._aside.lift()
        self.events.append(WalkEvent(t, "lost", step.number, foot))
        return True

    # -- a tick ---------------------------------------------------------------------------------

    def advance(
        self, t: float, dt: float, loads: Sequence[float], find_soles: Callable[[], Stance]
    ) -> tuple[int, ...]:
        """Go on to the tick of time `t` [s] that lasts `dt` [s]; return the feet that carry in it.

        `loads` (2,) [N] are the normal forces at the soles; `find_soles` says where they are, and
        is asked at a touchdown only.
        """
        s = self.clock.t
        if self._swing is not None:
            self._step_aside(self._swing, s, dt)
            self._look_for_ground(t, s, loads, find_soles)
        elif self._landed is not None:
            self._look_for_bounce(t, dt, loads)
        if self.stands and self._wanted:
            self._begin(s)
        if self._swing is None and self._left:
            following = next(one for one in self.plan.steps if one.number == self._number)
            if s >= following.lift - 1e-9:
                self._lift(t, following)
        if self.stands and not self._stood:
            self._stood = True
            self.events.append(WalkEvent(t, "stood"))
        self._write()
        gone = self.clock.advance(dt) - s
        for foot in BOTH:
            if self._searches[foot]:
                self._ahead[foot] += dt - gone
        return self.supports

    def _foot_time(self, foot: int) -> tuple[float, float]:
        """Return the time [s] by which a foot goes, and its rate."""
        rate = 1.0 if self._searches[foot] else self.clock.rate
        return self.clock.t + self._ahead[foot], rate

    def _lead(self, foot: int, path: FootPath, *, searches: bool = False) -> None:
        """Let a foot go on by another path, which it does by the time of the room if it searches.

        A path that does not begins at the clock of the plan.
        """
        self._paths[foot], self._searches[foot] = path, searches
        if not searches:
            self._ahead[foot] = 0.0

    def _begin(self, s: float) -> None:
        steps, self._wanted = self._wanted or [], None
        self.plan = self.planner.begin(self.stance, steps, s)
        heading = self.plan.heading
        self._heading += heading.at(s)[0] - self._last_heading
        self._left, self._stood, self._stops, self._number = list(steps), False, False, 1
        self._before = self.put_down

    def _lift(self, t: float, step: PlannedStep) -> None:
        here = self._paths[step.foot].at(self._foot_time(step.foot)[0]).T_world_sole
        shape = self.planner.settings.swing
        to = step.footstep.T_world_sole
        self._lead(step.foot, Swing(here, to, step.lift, step.land, shape))
        self._swing, self.supports = step, (1 - step.foot,)
        self._aside.lift()
        self._left, self._told = self._left[1:], False
        self._number = step.number + 1
        self.events.append(WalkEvent(t, "lift", step.number, step.foot))

    def _look_for_ground(
        self, t: float, s: float, loads: Sequence[float], find_soles: Callable[[], Stance]
    ) -> None:
        step = self._swing
        assert step is not None
        share = (s - step.lift) / (step.land - step.lift)
        if share > self.touch.earliest and loads[step.foot] > self.touch.load:
            self._land(t, s, step, find_soles()[step.foot])
        elif s >= step.land:
            self.clock.slowed = self._searches[step.foot] = True
            if s >= step.land + LATE and not self._told:
                self._told = True
                self.events.append(WalkEvent(t, "late", step.number, step.foot))

    def _step_aside(self, step: PlannedStep, s: float, dt: float) -> None:
        """Lead the foot to where the divergent component will be."""
        if self.balance is None or not self._aside.reach:
            return
        if self.balance.acts:
            left = step.land - s
            R = step.footstep.T_world_sole.rotation
            self._aside.want(self.balance.after(max(left, 0.0)), step.foot, R, left)
        self._aside.advance(dt)

    def _look_for_bounce(self, t: float, dt: float, loads: Sequence[float]) -> None:
        """Let a foot that landed early and came off again go on down, as long as it may."""
        step, s = self._landed, self.clock.t
        if step is None or s >= step.land - TOO_LATE:
            self._landed = None
            return
        self._off = self._off + dt if loads[step.foot] < OFF * self.touch.load else 0.0
        if self._off < self.touch.bounce:
            return
        sample, shape = self._paths[step.foot].at(s), self.planner.settings.swing
        probe = Probe(sample, s, self.touch.halt, shape.touchdown, shape.search)
        self._lead(step.foot, probe)
        self._swing, self.supports, self._landed = step, (1 - step.foot,), None
        self.events.append(WalkEvent(t, "bounce", step.number, step.foot))

    def _land(self, t: float, s: float, step: PlannedStep, T_here: pin.SE3) -> None:
        """Take the ground where it is, and plan on from there."""
        wanted, state = step.footstep.T_world_sole.copy(), None
        if self._aside.acts and self.balance is not None:
            shift = np.array([*self._aside.p, 0.0])
            wanted.translation += shift
            self._left = [moved_by(one, shift) for one in self._left]
            if self._wanted is not None:
                self._wanted = [moved_by(one, shift) for one in self._wanted]
            state = self.balance.hand_over(self.plan.centre.at(s))
            self.events.append(WalkEvent(t, "aside", step.number, step.foot, off=tuple(shift)))
        off = T_here.translation - wanted.translation
        z = float((wanted if abs(off[2]) <= self.touch.level else T_here).translation[2])
        T = level_pose(T_here.translation[0], T_here.translation[1], z, yaw_of(T_here))
        begin, searches = self._foot_time(step.foot)[0], self._searches[step.foot]
        sample = self._aside.moved(self._paths[step.foot].at(begin))
        wait = max(step.land - s, 0.0)
        glide = Glide(sample, T, begin, self.touch.glide, self.touch.halt, wait)
        self._lead(step.foot, glide, searches=searches)
        self.stance = with_foot(self.stance, step.foot, T)
        if self._wanted is not None:
            self._left, self._wanted = self._wanted, None
        if self._stops:
            self._left = self._closing(1 - step.foot)
            self._stops = False
            self.events.append(WalkEvent(t, "stop"))
        self.plan = self.planner.go_on(
            self.plan, s, self.stance, self._left, step.number + 1, wait, state
        )
        self._aside.lift()
        self._swing, self.supports, self.clock.slowed = None, BOTH, False
        self._landed, self._off = step, 0.0
        self.put_down = max(self.put_down, self._before + step.number)
        self.events.append(
            WalkEvent(t, "touch", step.number, step.foot, step.land - s, (off[0], off[1], off[2]))
        )

    def _closing(self, foot: int) -> list[Footstep]:
        """Return the step that ends the walk.

        It is made on the spot, too: the centre of mass was on its way over the other foot.
        """
        if self._left:
            return [Footstep(foot, self.stance[1 - foot] * self._beside[foot])]
        return closing_step(self.planner.feet, self.stance, foot, self._beside[foot])

    def _write(self) -> None:
        """Lead the targets to where they are wanted now."""
        s, rate = self.clock.t, self.clock.rate
        for foot, path in enumerate(self._paths):
            if self._at_rest[foot] is path:
                continue
            row, (now, pace) = self.targets.soles[foot].row(s), self._foot_time(foot)
            path.write_row(now, pace, row)
            if self._swing is not None and foot == self._swing.foot:
                self._aside.move_row(pace, row)
            self._at_rest[foot] = path if now >= path.rests_from else None
        x, y, vx, vy = self.plan.centre.motion(s)
        ground, rise = self.plan.ground.at(s)
        z = self.planner.settings.height + ground
        self.targets.centre.write_point((x, y, z), (rate * vx, rate * vy, rate * rise))
        heading, spin = self.plan.heading.at(s)
        self._last_heading = heading
        turned = (heading - self._heading, rate * spin)
        if self.targets.carrier is not None:
            place, speed = np.array([x, y, ground]), rate * np.array([vx, vy, rise])
            self.targets.carrier.write_displaced(self._start, place, speed, turned)
        if turned == self._turned:
            return
        self._turned = turned
        for led, columns in self._upright:
            led.write_heading(columns, *turned)
