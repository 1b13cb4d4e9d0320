"""What a joint of an MJCF may do: its range, and the torque that its actuators have."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from equipoise.robots.files.extras_schema import LimitEntry
from equipoise.robots.files.finding import WARNING, Finding
from equipoise.robots.files.mjcf.compiled import FREE, HINGE, joint_name

TURNS, LENGTH = 200.0 * math.pi, 10.0  # [rad], [m] of a joint without a range, to either side
SPEED = {True: 2.0 * math.pi, False: 1.0}  # [rad/s], [m/s]: an MJCF knows no limits of speed
EFFORT = 1000.0  # [N m] or [N] where nothing limits it
NOTHING, TO_JOINT, AT_JOINT = 0, 0, 1  # mjtBias, mjtTrn


@dataclass(frozen=True)
class JointLimits:
    """Limits of a joint: position [rad or m], speed, effort [N m or N]."""

    lower: float
    upper: float
    velocity: float
    effort: float


def limits_of(
    compiled: Any, corrections: dict[str, LimitEntry], following: Collection[str] = ()
) -> tuple[dict[int, JointLimits], list[Finding]]:
    """Return the limits by joint, and what had to be assumed, each told once.

    Of joints that are `following` others nothing is told: these are driven by their leaders.
    """
    found: dict[int, JointLimits] = {}
    slow, weak, idle, endless = [], [], [], []
    for joint in range(compiled.njnt):
        if compiled.jnt_type[joint] == FREE:
            continue
        name, turning = joint_name(compiled, joint), compiled.jnt_type[joint] == HINGE
        given = corrections.get(name, LimitEntry())
        lower, upper = (float(x) for x in compiled.jnt_range[joint])
        if not compiled.jnt_limited[joint]:
            upper = TURNS if turning else LENGTH
            lower = -upper
            endless += [] if turning or given.lower is not None else [name]
        effort, driven = effort_of(compiled, joint)
        if name not in following:
            idle += [] if driven else [name]
            weak += [] if given.effort or effort or not driven else [name]
            slow += [] if given.velocity else [name]
        found[joint] = JointLimits(
            lower if given.lower is None else given.lower,
            upper if given.upper is None else given.upper,
            given.velocity or SPEED[bool(turning)],
            given.effort or effort or EFFORT,
        )
    return found, [
        *_told(slow, "an MJCF has no limits of speed: 6.28 rad/s or 1 m/s are taken", "velocity"),
        *_told(weak, f"nothing limits the torque: {EFFORT:g} N m (or N) are taken", "effort"),
        *_told(endless, f"slides without a range: +-{LENGTH:g} m are taken", "lower and upper"),
        *_told(idle, "no actuator drives it: it counts as driven", "effort, or lock it"),
    ]


def effort_of(compiled: Any, joint: int) -> tuple[float | None, bool]:
    """Return what all actuators together can do at a joint (None: unlimited), and if there is one.

    An actuator counts with its gear; a position servo by its `forcerange`, a motor also by what
    its `ctrlrange` lets it do. The joint's own `actuatorfrcrange` bounds them together.
    """
    total, driven, limited = 0.0, False, True
    for k in range(compiled.nu):
        acts = compiled.actuator_trntype[k] in (TO_JOINT, AT_JOINT)
        if not acts or compiled.actuator_trnid[k, 0] != joint:
            continue
        gear, driven = abs(float(compiled.actuator_gear[k, 0])), True
        bounds = []
        if compiled.actuator_forcelimited[k]:
            bounds.append(np.abs(compiled.actuator_forcerange[k]).max())
        plain = compiled.actuator_biastype[k] == NOTHING and compiled.actuator_gaintype[k] == 0
        if plain and compiled.actuator_ctrllimited[k] and not compiled.actuator_dyntype[k]:
            gain = abs(float(compiled.actuator_gainprm[k, 0]))
            bounds.append(gain * np.abs(compiled.actuator_ctrlrange[k]).max())
        limited = limited and bool(bounds)
        total += gear * float(min(bounds, default=0.0))
    effort = total if driven and limited and total > 0.0 else None
    if compiled.jnt_actfrclimited[joint]:
        own = float(np.abs(compiled.jnt_actfrcrange[joint]).max())
        effort = own if effort is None else min(own, effort)
    return effort or None, driven


def _told(names: list[str], problem: str, keys: str) -> list[Finding]:
    if not names:
        return []
    who = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
    remedy = f"Give it in the robot's YAML under limits ({keys})"
    return [Finding(WARNING, f"joint {who}", problem, remedy)]
