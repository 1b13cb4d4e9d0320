"""A walk: its steps, how long they last, and how the feet swing."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from equipoise.scenarios.schema.base import NotNegative, Positive, Section, Vector3

FootName = Literal["left", "right"]


class StepsAlongSpec(Section):
    """`count` steps, of which the last puts the feet side by side again.

    The place between the feet goes on by `forward` and `left` [m], `turn` [rad] and `up` [m] a
    step. What is sideways and turned of two steps is taken by the foot on the side it goes to, and
    the other one follows. `first`: the foot that begins; left out, the one on the side it goes to,
    or the right one.
    """

    count: Annotated[int, Field(ge=1, le=1000)]
    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0
    up: float = 0.0
    first: FootName | None = None


class StepsToSpec(Section):
    """Steps to a `goal`: x, y [m] and heading [rad] of the place between the feet.

    No foot is put more than `forward` [m] ahead of the other, `side` [m] wider apart than they
    stand, or turned more than `turn` [rad] from it. Obstacles are not looked at.
    """

    goal: Vector3
    forward: Positive = 0.2
    side: Positive = 0.08
    turn: Positive = 0.25


class FootstepSpec(Section):
    """A foot is put down where the frame of its sole is at `xyz` [m], heading to `yaw` [rad]."""

    foot: FootName
    xyz: Vector3
    yaw: float = 0.0


class StickSpec(Section):
    """From `at` [s] on it walks `forward` and to the `left` [m/s], and turns by `turn` [rad/s].

    What is left out is zero; with nothing it stops, feet side by side.
    """

    at: NotNegative
    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0


class StrideSpec(Section):
    """How far a step of a walk that is steered may go; what is more is cut off, and told.

    No foot is put more than `forward` [m] ahead of the other, `side` [m] wider apart than they
    stand, or turned more than `turn` [rad] from it.
    """

    forward: Positive = 0.2
    side: Positive = 0.04
    turn: Positive = 0.25


class WalkTimingSpec(Section):
    """How long the phases last.

    `single`: a foot is in the air. `double`: both feet carry while the load goes over. `shift`: how
    long the load takes from the middle to the first foot that carries alone, and back from the last
    one; of slow steps, the centre of mass from foot to foot. `settle`: how long it stands before
    and after; of slow steps, before each foot is lifted.
    """

    single: Positive = 0.8
    double: Positive = 0.4
    shift: Positive = 1.0
    settle: Positive = 0.5


class SwingSpec(Section):
    """How a foot swings: `height` over the higher end of its way, `touchdown` [m/s] downwards.

    It goes on down at that speed, by `search` [m] at most, where there is no ground.
    """

    height: Positive = 0.05
    touchdown: Positive = 0.03
    search: NotNegative = 0.04


class BalanceSpec(Section):
    """The wanted centre of mass gives way to a push, and comes back (docs: walking).

    `gain` [1/s]: rate at which an error of the divergent component dies out. `margin` [m]: how far
    inside the soles the zero-moment point is kept meanwhile. `leash` [m]: how far the divergent
    component may be from its reference before the reference goes with it. `step` [m]: how far from
    its plan a foot may be put down to catch the robot; zero: never.
    """

    gain: Positive = 3.0
    margin: NotNegative = 0.01
    leash: Positive = 0.01
    step: NotNegative = 0.0


class WalkSpec(Section):
    """The robot walks (docs: walking): two sole contacts are lifted and put down step by step.

    `mode`: `pendulum`, it falls from foot to foot; `slow`, the centre of mass is moved over a foot
    before the other is lifted. Exactly one of `along`, `to`, `steps` and `steer` says where the
    feet go. `steer`: how fast it walks from when on, as a stick would say it; footsteps are made
    anew at each touchdown, within a `stride`.
    `crouch` [m]: how much lower than at half-sitting the centre of mass is. `inward` [m]: how much
    nearer to the other foot than the middle of a sole its load is led. `margin` [m]: how far inside
    the soles the planned zero-moment point has to be. `legs`: whether the centre of mass makes room
    for what a swinging leg weighs, by the nominal masses (`massless`: it does not). `stop` [s]:
    when it is told to stop. `balance`: how the centre of mass gives way to pushes; left out, it
    does not. `lean`: whether the centre of mass leans into what hands are wanted to push with.
    With `steps: []` it stands.

    The feet have level 0, the centre of mass `priority`, and the trunk, which stays upright and
    turns with the feet, `trunk_priority`.
    """

    mode: Literal["pendulum", "slow"] = "pendulum"
    along: StepsAlongSpec | None = None
    to: StepsToSpec | None = None
    steps: Annotated[list[FootstepSpec], Field(max_length=1000)] | None = None
    steer: Annotated[list[StickSpec], Field(max_length=1000)] | None = None
    stride: StrideSpec = StrideSpec()
    timing: WalkTimingSpec = WalkTimingSpec()
    swing: SwingSpec = SwingSpec()
    crouch: NotNegative = 0.03
    inward: NotNegative = 0.0
    margin: NotNegative = 0.005
    legs: Literal["massless", "nominal"] = "nominal"
    stop: Positive | None = None
    balance: BalanceSpec | None = None
    lean: bool = True
    priority: Annotated[int, Field(ge=1, le=20)] = 2
    trunk_priority: Annotated[int, Field(ge=1, le=20)] = 3
    foot_rate: Positive = 20.0
    rate: Positive = 10.0

    @model_validator(mode="after")
    def _one_way(self) -> WalkSpec:
        if sum(one is not None for one in (self.along, self.to, self.steps, self.steer)) != 1:
            raise ValueError("give exactly one of along, to, steps and steer")
        return self

    @model_validator(mode="after")
    def _in_order(self) -> WalkSpec:
        times = [one.at for one in self.steer or ()]
        if any(one >= other for one, other in pairwise(times)):
            raise ValueError("each entry of steer comes after the one before")
        return self
