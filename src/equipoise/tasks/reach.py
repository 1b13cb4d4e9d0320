"""What is asked of a frame that its target has left behind: as far as it gets, and no fits.

Where a target is out of reach, the exact answer of the hierarchy swings between plus and minus the
speed limits: a stretched arm is singular. While a frame is behind, its level asks for

    |J v - p|^2 + damping^2 |v_j|^2 + (mass / period) |v_j - v_before|^2  ->  least,

which is a mass with a damper that is drawn to the target: it starts smoothly, stretches as far as
limits and balance let it, and comes to rest there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equipoise.compiled import compiled, inlined
from equipoise.compiled.workspace import vector
from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.kinematics.kernels import VELOCITY
from equipoise.robots import Robot, require_robot
from equipoise.robots.arm_span import ArmSpan
from equipoise.spatial import Array
from equipoise.spatial.numbers import (
    not_negative,
    positive,
    real_array,
    real_number,
    real_vector,
    require_period,
)
from equipoise.tasks.reach_memory import (
    CALLED,
    CALM,
    CLOSE,
    DAMPING,
    EACH,
    FREE,
    FULL,
    HEAVY,
    HOME_RATE,
    HOMING,
    JOINTS,
    LATE,
    LEVER,
    MASS,
    PERIOD,
    PULL,
    PULL_TURN,
    SHOULDER,
    SLOW,
    SWING,
    remember,
)
from equipoise.tasks.view import TaskView, joint_positions


@dataclass(frozen=True)
class Reach:
    """How a frame goes for a target that it is behind, or cannot reach at all.

    It is drawn by at most `pull` [m/s] and `pull_turn` [rad/s]. More than 2 cm or 0.1 rad behind,
    its joints are damped (`damping`, m/s on the frame's level for each rad/s) and have a `mass`
    [s], each times the square of its own of `weights` (na,), and levels below get nothing. So an
    arm is stretched before legs and trunk lean. Nearer, levels below get all that is left, but no
    joint may change its speed faster than `change` [rad/s^2], so that they come back without a
    jump, nor exceed `fastest` [rad/s], which an arm that is nearly stretched would. These two are
    one number or one for each joint (na,). Within `close` [m] of the target `fastest` grows as
    the distance falls, so that a target that is followed well is followed exactly. `home` (na,) is
    where a joint that is damped goes by itself, by at most `homing` [rad/s] over its weight: a
    straight arm that is called back has to begin to bend somehow. `period` [s] is that of the
    generator. With a `span` all of this is only for what the arm cannot get to: it begins when the
    target jumps farther from where the shoulder was at the start than the second of `edges` [m]; or
    is there, or beyond the first with the arm stretched that way, and the frame 5 mm behind; or
    when the frame was 2 cm behind for long (0.4 s at a rate of 10), or a joint swings. It ends when
    the target is back and the frame follows it well, or the arm is bent. Before and after it is
    followed exactly.
    Source: Sugihara 2011 (Levenberg-Marquardt); the mass in place of a damping that grows with the
    error is ours: it keeps the velocity continuous where following turns into being drawn.
    Raises: `InputError`, `ShapeError`.
    """

    robot: Robot
    period: float
    pull: float = 0.3
    pull_turn: float = 0.6
    damping: float = 0.25
    mass: float = 0.005
    weights: float | Array = 1.0
    change: float | Array = 30.0
    fastest: float | Array = math.inf
    close: float = 0.0
    home: Array | None = None
    homing: float = 0.05
    span: ArmSpan | None = None
    edges: tuple[float, float] = (math.inf, math.inf)

    def __post_init__(self) -> None:
        require_robot("the robot whose joints a reach damps", self.robot)
        require_period(self.period)
        for name in ("damping", "close", "homing"):
            not_negative(f"the {name} of a reach", getattr(self, name))
        positive("the mass of a reach", self.mass, "s")
        if self.span is not None:
            require_kind("the span of a reach", self.span, ArmSpan)
            for edge in self.edges:
                positive("an edge of a reach", edge, "m")
        for name in ("pull", "pull_turn"):
            drawn = real_number(f"the {name.replace('_', ' ')}", getattr(self, name), finite=False)
            if not drawn > 0.0:
                raise InputError(f"the {name.replace('_', ' ')} of a reach must be positive")
        for name in ("weights", "change", "fastest"):
            if not (self._each(name) > 0.0).all():
                raise InputError(f"the {name} of a reach must be positive")
        if self.home is not None:
            real_vector("the home of a reach", self.home, self.robot.na)

    def _each(self, name: str) -> Array:
        """Return a number for each joint (na,)."""
        given = getattr(self, name)
        what, na = f"the {name} of a reach", self.robot.na
        if isinstance(given, int | float):
            return np.full(na, real_number(what, given, finite=False))
        return real_array(what, given, (na,), finite=False)

    @property
    def numbers(self) -> Array:
        """What the kernel needs, in the order of its entries."""
        alike = [self.pull, self.pull_turn, self.damping, self.mass, self.period, self.robot.na]
        alike += [self.close, 0.0 if self.home is None else self.homing]
        alike += [-1.0] + [0.0] * (EACH - SHOULDER - 1)
        if self.span is not None:
            alike[SHOULDER:CALM] = [
                self.span.shoulder, *self.span.p_world_shoulder, *self.span.p_frame_wrist,
                *self.edges,
            ]  # fmt: skip
        else:
            alike[CALM] = 1.0
        home = np.zeros(self.robot.na) if self.home is None else self.home
        joints = map(self._each, ("weights", "change", "fastest"))
        return np.concatenate((alike, *joints, home, np.zeros_like(home)))


@compiled
def bound_reach(task: TaskView, error: tuple[float, float, float, float, float, float]) -> None:
    """Bound the pull of the six rows of a frame, and write a row for each joint below them."""
    lower, at, numbers, target = task.lower, task.at, task.numbers, task.target
    far = math.sqrt(error[0] ** 2 + error[1] ** 2 + error[2] ** 2)
    angle = math.sqrt(error[3] ** 2 + error[4] ** 2 + error[5] ** 2)
    beyond = max(far - FREE, 0.0) + max(LEVER * angle - FREE, 0.0)
    near = max(far + LEVER * angle, 1e-9)
    share = min(beyond / FULL, 1.0)
    if numbers[SHOULDER] >= 0.0:
        share *= remember(task, near, beyond)
        bound_swings(task)
        if numbers[CALM] == 0.0 and numbers[SLOW] != 0.0:
            calm_joints(task, 0.0, near)
        if numbers[LATE] == 0.0:
            return
    for i in range(6):
        lower[at + i] = task.rate * error[i]
    shorten(lower, at, numbers[PULL])
    shorten(lower, at + 3, numbers[PULL_TURN])
    for i in range(6):
        lower[at + i] += (1.0 - share) * target[12 + i]
    if numbers[CALM] > 0.0:
        calm_joints(task, beyond, near)


@compiled
def bound_swings(task: TaskView) -> None:
    """Let no joint change its speed as only swinging ones do; free joints that start at rest."""
    v, numbers, na = vector(task.state, VELOCITY), task.numbers, int(task.numbers[JOINTS])
    first, last, most = v.shape[0] - na, EACH + 4 * na, SWING * numbers[PERIOD]
    moving = False
    for i in range(na):
        moving = moving or numbers[last + i] != 0.0
    for i in range(na):
        row = task.at + 6 + i
        task.lower[row], task.upper[row] = -np.inf, np.inf
        if moving:
            task.A[row, first + i] = 1.0
            task.lower[row], task.upper[row] = v[first + i] - most, v[first + i] + most


@compiled
def calm_joints(task: TaskView, beyond: float, near: float) -> None:
    """Write a row for each joint: damped with a mass where the frame is behind, else bounded.

    While the frame comes back light joints become free; heavy ones keep their bounds, since what
    leans to an edge of the feet may leave it only slowly.
    """
    at, numbers, calm = task.at, task.numbers, task.numbers[CALM]
    faster = numbers[CLOSE] / near if near < numbers[CLOSE] else 1.0
    na, mass, returns = int(numbers[JOINTS]), numbers[MASS], calm < 1.0
    first, dt, inertia = task.A.shape[1] - na, numbers[PERIOD], mass / numbers[PERIOD]
    v = vector(task.state, VELOCITY)
    before = v[v.shape[0] - na :]
    damped = beyond > 0.0 and not returns
    resistance = numbers[DAMPING] ** 2 * min(beyond / FULL, 1.0) if damped else 0.0
    w, q = math.sqrt(inertia + resistance), joint_positions(task.state, na)
    for i in range(na):
        row, weight, change = at + 6 + i, w * numbers[EACH + i], 0.0
        most = numbers[HOMING] / numbers[EACH + i]
        if numbers[CALLED] != 0.0 and numbers[EACH + i] > HEAVY:
            most = max(most, 0.5 * numbers[EACH + na + i] / HOME_RATE)
        home = min(max(numbers[EACH + 3 * na + i] - q[i], -most), most)
        kept = (inertia * before[i] + resistance * home) / (inertia + resistance)
        fastest = numbers[EACH + 2 * na + i] * faster
        if not damped:
            change = numbers[EACH + na + i]
        if returns and numbers[EACH + i] > HEAVY:
            fastest = max(fastest, change / HOME_RATE)
        elif returns:
            if calm == 0.0:
                continue
            fastest, change = fastest / calm, change / calm
        change *= dt
        task.A[row, first + i] = weight
        task.lower[row] = weight * min(max(-fastest, kept - change), kept + change)
        task.upper[row] = weight * min(max(fastest, kept - change), kept + change)


@inlined
def shorten(x: np.ndarray, at: int, longest: float) -> None:
    """Shorten the three numbers x[at : at + 3] to a length, keeping their direction."""
    length = math.sqrt(x[at] ** 2 + x[at + 1] ** 2 + x[at + 2] ** 2)
    if length > longest:
        for i in range(at, at + 3):
            x[i] *= longest / length
