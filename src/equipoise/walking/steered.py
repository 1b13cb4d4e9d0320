"""A walk that is steered: its footsteps are made anew at each touchdown, from how fast it is to go.

The place between the feet goes on by the velocity times the time of a step. What is too far for a
step is cut off; where a change cannot be balanced at once, it is made in several steps. Both are
told, and nothing is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pinocchio as pin

from equipoise.given import require_kind
from equipoise.walking.feasible import WalkLimits, is_feasible
from equipoise.walking.feet import Stance, level_pose, with_foot
from equipoise.walking.footsteps import Footstep, StrideLimits
from equipoise.walking.plan import PlannedStep, WalkPlan
from equipoise.walking.stick import Clip, Stick, clipped
from equipoise.walking.walker import Walker

PREVIEW = 2  # steps by the stick that a plan looks ahead, before one that closes
CHECKED = 2  # of them have to be balanced: the next touchdown makes the others anew
SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)  # of a change that are tried, the largest one first
LOOKS = 0.05  # [s] between two looks at a stick that moves on
NAMES = ("left", "right")
REST = "it comes to rest first: from here on it could not be balanced"
SLOWLY = "the walk changes in several steps: at once it could not be balanced"


class SteeredWalk:
    """Walks as long as a stick is held, and puts the feet side by side when it is let go.

    `advance` once a tick in place of that of the `walker`, which has to stand between its feet at
    first. `stick` may be set at any time: it counts from the next touchdown on, of a robot that
    stands at once. `goes` is how fast the next step goes: what the stick says, within `limits` of a
    step and what can be balanced within `checks`. `clips` tells where that is less, `clip` whether
    it is so now.
    Raises: `InputError`.
    """

    def __init__(
        self,
        walker: Walker,
        limits: StrideLimits | None = None,
        checks: WalkLimits | None = None,
    ) -> None:
        require_kind("who walks", walker, Walker)
        self.walker, self.limits = walker, limits or StrideLimits()
        self._checks = checks or WalkLimits()
        require_kind("the limits of a stride", self.limits, StrideLimits)
        require_kind("the limits of a walk", self._checks, WalkLimits)
        planner, stance = walker.planner, walker.stance
        middle = planner.feet.middle(stance)
        self._own = [middle.actInv(T) for T in stance]
        self._period = planner.period
        self._stick, self.goes = Stick(), Stick()
        self._going = Stick()  # of the step in the air
        self._made: tuple[PlannedStep | None, Stick] = (None, Stick())
        self._looked = -LOOKS
        self.clips: list[Clip] = []
        self.clip = ""

    @property
    def stick(self) -> Stick:
        """How fast it is wanted to walk."""
        return self._stick

    @stick.setter
    def stick(self, stick: Stick) -> None:
        require_kind("a stick", stick, Stick)
        self._stick = stick

    def advance(
        self, t: float, dt: float, loads: Sequence[float], find_soles: Callable[[], Stance]
    ) -> tuple[int, ...]:
        """Go on to the tick of time `t` [s] that lasts `dt` [s]; return the feet that carry in it.

        `loads` (2,) [N] are the normal forces at the soles; `find_soles` says where they are, and
        is asked at a touchdown only.
        """
        walker = self.walker
        if walker.stands:
            self._made, self._going, self.goes = (None, Stick()), Stick(), Stick()
            if self._stick.held:
                self._begin(t)
            elif self.clip:
                self.clip = ""
        elif walker.swinging is not None:
            self._go_on(t, walker.swinging)
        return walker.advance(t, dt, loads, find_soles)

    @property
    def sentence(self) -> str:
        """What it does, in words."""
        walker, step = self.walker, self.walker.swinging
        if walker.stands:
            return "It stands."
        if step is not None:
            swings = f"the {NAMES[step.foot]} foot swings"
            if self._stick.held:
                return f"It walks: {swings}."
            if walker.remaining:
                return f"It stops with the next step: {swings}."
            return f"It stops: {swings}."
        if not walker.remaining:
            return "It comes to rest."
        foot = walker.plan.steps[0].foot
        over = f"the weight goes over the {NAMES[1 - foot]} foot"
        return f"It walks: {over}." if self._stick.held else f"It stops with the next step: {over}."

    # -- making footsteps -----------------------------------------------------------------------

    def _begin(self, t: float) -> None:
        """Make the first steps of a robot that stands."""
        walker = self.walker
        planner = walker.planner
        wanted, cut = clipped(self._stick, self.limits, self._period)
        foot = wanted.first_foot(self.limits)
        place = planner.feet.middle(walker.stance)

        def steps(stick: Stick) -> list[Footstep]:
            return self._steps(place, foot, stick)

        def plan(steps: list[Footstep]) -> WalkPlan:
            return planner.begin(walker.stance, steps, walker.clock.t)

        self._take(t, steps, plan, wanted, cut)
        self._going = self.goes

    def _go_on(self, t: float, step: PlannedStep) -> None:
        """Make the steps that follow the one in the air, if it or the stick is another one."""
        walker, (made, stick) = self.walker, self._made
        if step is made and (stick == self._stick or t - self._looked < LOOKS):
            return
        if step is not made:
            self._going = self.goes
        self._made, self._looked = (step, self._stick), t
        if not self._stick.held:
            self.goes, self.clip = Stick(), ""
            if walker.remaining or step is made:  # else it closes its feet anyhow
                walker.stop()
            return
        planner = walker.planner
        wanted, cut = clipped(self._stick, self.limits, self._period)
        T = step.footstep.T_world_sole
        stance = with_foot(walker.stance, step.foot, T)
        place = T * self._own[step.foot].inverse()

        def steps(stick: Stick) -> list[Footstep]:
            return self._steps(place, 1 - step.foot, stick)

        def plan(steps: list[Footstep]) -> WalkPlan:
            at = max(step.land, walker.clock.t)
            return planner.go_on(walker.plan, at, stance, steps, step.number + 1)

        self._take(t, steps, plan, wanted, cut)

    def _take(
        self,
        t: float,
        steps: Callable[[Stick], list[Footstep]],
        plan: Callable[[list[Footstep]], WalkPlan],
        wanted: Stick,
        cut: str,
    ) -> None:
        """Let the walker walk on as wanted, or as near to it as can be balanced."""
        feet, settings = self.walker.planner.feet, self.walker.planner.settings
        stops = not self.walker.remaining and self.walker.swinging is not None
        for share in SHARES:
            stick = self._going.towards(wanted, share)
            made = steps(stick)
            if is_feasible(plan(made), feet, settings, self._checks, CHECKED):
                break
        else:
            if stops:
                self._tell(t, REST)
                return
        self.goes = stick
        self.walker.walk_on(made)
        self._tell(t, "; ".join(one for one in (cut, SLOWLY if share < 1.0 else "") if one))

    def _tell(self, t: float, words: str) -> None:
        if words and words != self.clip:
            self.clips.append(Clip(t, words))
        self.clip = words

    def _steps(self, place: pin.SE3, foot: int, stick: Stick) -> list[Footstep]:
        """Return steps by a stick from a `place` between the feet on, and one that closes."""
        made = []
        for _ in range(PREVIEW):
            stride = stick.stride(foot, self._period)
            place = place * level_pose(stride.forward, stride.left, 0.0, stride.turn)
            made.append(Footstep(foot, place * self._own[foot]))
            foot = 1 - foot
        return [*made, Footstep(foot, place * self._own[foot])]
