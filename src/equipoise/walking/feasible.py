"""Whether a planned walk can be walked, as far as the ground tells: said before the first step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from equipoise.contacts.support_polygon import sole_corners
from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, positive
from equipoise.walking.feet import LEFT, RIGHT, Feet, Stance, with_foot
from equipoise.walking.plan import PlannedStep, WalkPlan
from equipoise.walking.settings import GRAVITY, WalkMode, WalkSettings
from equipoise.walking.swing import Swing

SAMPLE = 0.005  # [s] between the moments that are looked at
COARSE = 0.02  # [s] between them while the robot walks
NAMES = ("left", "right")


@dataclass(frozen=True)
class WalkLimits:
    """What a walk must keep: the ZMP `margin` [m] inside the soles, feet `apart` [m], no foot
    faster than `speed` [m/s] or sharper than `acceleration` [m/s^2] across.

    Raises: `InputError`.
    """

    margin: float = 0.005
    apart: float = 0.01
    speed: float = 3.0
    acceleration: float = 40.0

    def __post_init__(self) -> None:
        not_negative("the margin of the zero-moment point", self.margin, "m")
        not_negative("how far feet stay apart", self.apart, "m")
        positive("the speed of a foot", self.speed, "m/s")
        positive("the acceleration of a foot", self.acceleration, "m/s^2")


def zmp_at(plan: WalkPlan, settings: WalkSettings, t: float) -> Array:
    """Return the zero-moment point (2,) [m] that a plan asks for at `t` [s].

    Of a point mass and a leg that swings: where the centre of mass is raised or lowered this
    differs a little from what was planned.
    """
    state, h = plan.centre.at(t), 1e-3
    low, _ = plan.ground.at(t - h)
    here, _ = plan.ground.at(t)
    high, _ = plan.ground.at(t + h)
    lifted = (low - 2.0 * here + high) / h**2
    point: Array = state.p - settings.height / (GRAVITY + lifted) * state.a
    step = plan.swinging(t)
    if step is not None and settings.leg:
        swing = Swing(
            plan.stance_before(step)[step.foot], step.footstep.T_world_sole, step.lift, step.land,
            settings.swing,
        )  # fmt: skip
        point = point + settings.leg * swing.at(t).acceleration[:2]
    return point


def zmp_room(
    plan: WalkPlan,
    feet: Feet,
    settings: WalkSettings,
    until: float | None = None,
    sample: float = SAMPLE,
) -> Iterator[tuple[float, float, PlannedStep | None]]:
    """Yield time [s], distance [m] of the zero-moment point inside its soles, and the step.

    The step is the one in the air, or the last one that was put down. Looked at is every `sample`
    [s], to the end of the plan or `until` [s].
    """
    end = plan.end if until is None else min(until, plan.end)
    count = math.ceil((end - plan.centre.start) / sample)
    known: tuple[object, ...] = ()
    last: PlannedStep | None = None
    for t in np.linspace(plan.centre.start, end, count + 1).tolist():
        step = plan.swinging(t)
        last = step or last
        standing = (LEFT, RIGHT) if step is None else (1 - step.foot,)
        stance = plan.stance_at(t)
        if known != (stance, standing):
            known, polygon = (stance, standing), feet.support(stance, standing)
        yield t, polygon.margin(zmp_at(plan, settings, t)), last


def require_feasible(
    plan: WalkPlan, feet: Feet, settings: WalkSettings, limits: WalkLimits | None = None
) -> None:
    """Refuse a plan whose zero-moment point leaves the soles, or whose feet meet or are too fast.

    Raises: `InputError` naming the first step and why.
    """
    limits = limits or WalkLimits()
    _require_swings(plan, feet, settings, limits)
    rooms = list(zmp_room(plan, feet, settings))
    first = next((step for _, room, step in rooms if room < limits.margin), plan)
    if first is plan:
        return
    t, room, step = min((one for one in rooms if one[2] is first), key=lambda one: one[1])
    if settings.mode is WalkMode.SLOW:
        remedy = "Give a longer shift, or feet that are nearer to each other"
    else:
        remedy = "Give longer times (shift, settle, double), or shorter steps"
    where = "before the first step" if step is None else f"at {step_name(step)}"
    side = f"{1e3 * room:.1f} mm inside" if room >= 0.0 else f"{-1e3 * room:.1f} mm outside"
    raise InputError(
        f"the walk cannot be balanced {where}: the zero-moment point would be {side} the soles "
        f"at t = {t:.2f} s, and {1e3 * limits.margin:.0f} mm inside are wanted",
        remedy=remedy,
    )


def is_feasible(
    plan: WalkPlan, feet: Feet, settings: WalkSettings, limits: WalkLimits, steps: int
) -> bool:
    """Return whether the first `steps` of a plan can be balanced, and their feet keep apart.

    Looked at less often than by `require_feasible`: it is asked while the robot walks.
    """
    until = plan.steps[steps - 1].land if len(plan.steps) >= steps else plan.end
    rooms = zmp_room(plan, feet, settings, until, COARSE)
    if any(room < limits.margin for _, room, _ in rooms):
        return False
    try:
        _require_swings(plan, feet, settings, limits, steps)
    except InputError:
        return False
    return True


def _require_swings(
    plan: WalkPlan,
    feet: Feet,
    settings: WalkSettings,
    limits: WalkLimits,
    steps: int | None = None,
) -> None:
    stance = plan.stance
    for one in plan.steps[:steps]:
        swing = Swing(
            stance[one.foot], one.footstep.T_world_sole, one.lift, one.land, settings.swing
        )
        for what, value, most, unit in (
            ("fast", swing.fastest, limits.speed, "m/s"),
            ("sharp", swing.sharpest, limits.acceleration, "m/s^2"),
        ):
            if value > most:
                raise InputError(
                    f"{step_name(one)} is too {what}: its foot would come to {value:.2f} {unit}, "
                    f"and {most:g} are allowed",
                    remedy="Give a longer single phase, or shorter steps",
                )
        nearest = _nearest(feet, stance, one, swing)
        if nearest < limits.apart:
            raise InputError(
                f"{step_name(one)} meets the other foot: they would come to "
                f"{1e3 * nearest:.0f} mm of each other, and {1e3 * limits.apart:.0f} mm are wanted",
                remedy="Give steps that are wider apart or turn less",
            )
        stance = with_foot(stance, one.foot, one.footstep.T_world_sole)


def _nearest(feet: Feet, stance: Stance, step: PlannedStep, swing: Swing) -> float:
    """Return how near [m] the sole of a swing comes to the other one, seen from above.

    Negative where they overlap. Distance of rectangles along the axes of both: never too large.
    """
    other = sole_corners(feet.soles[1 - step.foot], stance[1 - step.foot])[:, :2]
    nearest = math.inf
    for t in np.linspace(step.lift, step.land, 41).tolist():
        T = swing.at(t).T_world_sole
        corners = sole_corners(feet.soles[step.foot], T)[:, :2]
        axes = (*_axes(T.rotation), *_axes(stance[1 - step.foot].rotation))
        nearest = min(nearest, max(_gap(corners @ n, other @ n) for n in axes))
    return nearest


def _axes(R: Array) -> tuple[Array, Array]:
    return R[:2, 0], R[:2, 1]


def _gap(one: Array, other: Array) -> float:
    """Return the distance of two intervals, negative where they overlap."""
    return float(max(one.min() - other.max(), other.min() - one.max()))


def step_name(step: PlannedStep) -> str:
    """Return what a step is called."""
    return f"step {step.number} ({NAMES[step.foot]} foot)"
