"""Where the feet go: steps along a way, to a goal, up and down, or one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive, real_number, real_vector
from equipoise.spatial.poses import rigid
from equipoise.walking.feet import (
    LEFT,
    RIGHT,
    Feet,
    Stance,
    level_pose,
    require_stance,
    turn_between,
    with_foot,
)

MOST_STEPS = 1000
CLOSED = 0.01  # [m], [rad] up to which two feet count as side by side


@dataclass(frozen=True)
class Footstep:
    """A foot (`LEFT` or `RIGHT`) is put down at a pose of the frame of its sole.

    Raises: `InputError`.
    """

    foot: int
    T_world_sole: pin.SE3

    def __post_init__(self) -> None:
        _foot(self.foot)
        rigid("the pose of a footstep", self.T_world_sole)


@dataclass(frozen=True)
class Stride:
    """How far a step goes on: forwards and to the left [m], turning [rad] to the left, up [m]."""

    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0
    up: float = 0.0

    def __post_init__(self) -> None:
        for name in ("forward", "left", "turn", "up"):
            real_number(f"how far a step goes {name}", getattr(self, name))


@dataclass(frozen=True)
class StrideLimits:
    """How far a foot may be put from the other: ahead of it, wider apart [m], and turned [rad]."""

    forward: float = 0.2
    side: float = 0.08
    turn: float = 0.25

    def __post_init__(self) -> None:
        for name in ("forward", "side", "turn"):
            positive(f"the longest step {name}", getattr(self, name))


def steps_along(
    feet: Feet, stance: Stance, stride: Stride, count: int, first: int | None = None
) -> list[Footstep]:
    """Return `count` steps from a stance, of which the last puts the feet side by side again.

    The place between the feet goes on by a stride a step. A foot steps beside the other, never
    across: the foot on the side it goes or turns to takes what is sideways and turned of two
    steps, and the other one follows. It begins with that foot, unless `first` says otherwise; with
    the right one where it goes straight on.
    Raises: `InputError`.
    """
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= MOST_STEPS:
        raise InputError(f"the number of steps is 0 to {MOST_STEPS}", given=count)
    require_stance(feet, stance)
    require_kind("a stride", stride, Stride)
    towards = stride.left if abs(stride.left) > 0.0 else stride.turn
    leading = LEFT if towards > 0.0 else RIGHT
    foot = leading if first is None else _foot(first)
    middle = feet.middle(stance)
    own = [middle.actInv(T) for T in stance]
    steps = []
    for k in range(count):
        last = k == count - 1
        leads = 2.0 if foot == leading else 0.0
        if not last:
            middle = middle * level_pose(
                stride.forward, leads * stride.left, stride.up, leads * stride.turn
            )
        steps.append(Footstep(foot, middle * own[foot]))
        foot = 1 - foot
    return steps


def steps_to(
    feet: Feet, stance: Stance, goal: Sequence[float], limits: StrideLimits | None = None
) -> list[Footstep]:
    """Return steps after which the place between the feet is at `goal` (x [m], y [m], yaw [rad]).

    What is near is reached by steps in all directions; otherwise it turns to the goal, goes
    straight on, and turns there. Obstacles are not looked at.
    Raises: `InputError`.
    """
    require_stance(feet, stance)
    limits = StrideLimits() if limits is None else limits
    require_kind("the limits of a stride", limits, StrideLimits)
    x, y, yaw = real_vector("a goal, x [m], y [m] and yaw [rad],", goal, 3).tolist()
    here = feet.middle(stance)
    there = level_pose(x, y, here.translation[2], yaw)
    distance = float(np.linalg.norm(there.translation - here.translation))
    if distance <= 2.0 * limits.forward:
        return _beside(feet, stance, there, limits)
    bearing = math.atan2(y - here.translation[1], x - here.translation[0])
    steps: list[Footstep] = []
    z = float(here.translation[2])
    turned = level_pose(here.translation[0], here.translation[1], z, bearing)
    arrived = level_pose(x, y, z, bearing)
    for place in (turned, arrived, there):
        if place is arrived:
            count = math.ceil(distance / limits.forward - 1e-9) + 1
            _require_few(count, goal)
            stride = Stride(forward=distance / (count - 1))
            more = steps_along(feet, stance, stride, count, 1 - steps[-1].foot if steps else None)
        else:
            more = _beside(feet, stance, place, limits, 1 - steps[-1].foot if steps else None)
        stance = after(stance, more)
        steps += more
    return steps


def closing_step(feet: Feet, stance: Stance, foot: int, apart: pin.SE3) -> list[Footstep]:
    """Return the step that puts a foot beside the other, none where it is there already.

    `apart` is the pose of the foot in the frame of the other one when they stand side by side.
    """
    require_stance(feet, stance)
    rigid("how far the feet are apart", apart)
    T = stance[1 - _foot(foot)] * apart
    off = stance[foot].actInv(T)
    if np.linalg.norm(off.translation) < CLOSED and np.linalg.norm(pin.log3(off.rotation)) < CLOSED:
        return []
    return [Footstep(foot, T)]


def moved_by(step: Footstep, shift: Array) -> Footstep:
    """Return a footstep that is put elsewhere by `shift` (3,) [m]."""
    T = step.T_world_sole
    return Footstep(step.foot, pin.SE3(T.rotation, T.translation + shift))


def after(stance: Stance, steps: Sequence[Footstep]) -> Stance:
    """Return where the feet stand after steps."""
    for step in steps:
        stance = with_foot(stance, step.foot, step.T_world_sole)
    return stance


def _beside(
    feet: Feet, stance: Stance, there: pin.SE3, limits: StrideLimits, first: int | None = None
) -> list[Footstep]:
    """Return pairs of steps in all directions at once: a foot goes on, the other comes beside.

    The foot on the side it goes to begins. If the `first` one has to and is the other, which would
    step across, it makes a step on the spot before.
    """
    here = feet.middle(stance)
    way = here.actInv(there)
    turn = turn_between(0.0, math.atan2(way.rotation[1, 0], way.rotation[0, 0]))
    forward, left = float(way.translation[0]), float(way.translation[1])
    shares = abs(forward) / limits.forward, abs(left) / limits.side, abs(turn) / limits.turn
    pairs = math.ceil(max(shares) - 1e-9)
    if not pairs:
        return []
    _require_few(2 * pairs, there.translation[:2].tolist())
    towards = left if abs(left) / limits.side >= abs(turn) / limits.turn else turn
    foot = LEFT if towards > 0.0 else RIGHT
    own = [here.actInv(T) for T in stance]
    steps = []
    if first is not None and foot != first:
        steps.append(Footstep(first, stance[first]))
    for k in range(1, pairs + 1):
        place = here * _on_arc(way, k / pairs, turn)
        for one in (foot, 1 - foot):
            steps.append(Footstep(one, place * own[one]))
    return steps


def _require_few(count: int, goal: Sequence[float]) -> None:
    if count > MOST_STEPS:
        raise InputError(
            f"the goal is {count} steps away, and at most {MOST_STEPS} are taken",
            given=list(goal),
            remedy="Give a nearer goal",
        )


def _on_arc(way: pin.SE3, part: float, turn: float) -> pin.SE3:
    """Return a part of a level way along which the twist is constant and that turns by `turn`."""
    x, y, z = way.translation
    if abs(turn) < 1e-9:
        return level_pose(part * x, part * y, part * z, part * turn)
    speed = np.linalg.solve(_arc(turn), np.array([x, y]))
    x, y = _arc(part * turn) @ speed
    return level_pose(x, y, part * z, part * turn)


def _arc(turn: float) -> Array:
    """Return the matrix (2, 2) from a constant velocity, per turn, to where it leads."""
    c, s = math.cos(turn), math.sin(turn)
    return np.array([[s, c - 1.0], [1.0 - c, s]])


def _foot(foot: int) -> int:
    if isinstance(foot, bool) or not isinstance(foot, int) or foot not in (LEFT, RIGHT):
        raise InputError("a foot is LEFT (0) or RIGHT (1)", given=foot)
    return foot
