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
from equipoise.kinematics.kernels import VELOCITY
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import (
    not_negative,
    positive,
    real_array,
    real_number,
    real_vector,
    require_period,
)
from equipoise.tasks.view import TaskView, joint_positions

# entries of the numbers; then for each joint its weight, its change, its fastest, its home
PULL, PULL_TURN, DAMPING, MASS, PERIOD, JOINTS, CLOSE, HOMING, EACH = range(9)
FREE = 0.02  # [m] from the target nothing is damped
FULL = 0.1  # [m] beyond which a target is not followed in its speed, and the damping is whole
LEVER = 0.2  # [m] a turn counts as much as a way of this length for each radian


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
    generator.
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

    def __post_init__(self) -> None:
        require_robot("the robot whose joints a reach damps", self.robot)
        require_period(self.period)
        for name in ("damping", "close", "homing"):
            not_negative(f"the {name} of a reach", getattr(self, name))
        positive("the mass of a reach", self.mass, "s")
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
        home = np.zeros(self.robot.na) if self.home is None else self.home
        return np.concatenate((alike, *map(self._each, ("weights", "change", "fastest")), home))


@compiled
def bound_reach(task: TaskView, error: tuple[float, float, float, float, float, float]) -> None:
    """Write the six rows of a frame with its pull bounded, and a row for each joint below them."""
    lower, at, numbers, target = task.lower, task.at, task.numbers, task.target
    far = math.sqrt(error[0] ** 2 + error[1] ** 2 + error[2] ** 2)
    angle = math.sqrt(error[3] ** 2 + error[4] ** 2 + error[5] ** 2)
    beyond = max(far - FREE, 0.0) + max(LEVER * angle - FREE, 0.0)
    near = max(far + LEVER * angle, 1e-9)
    faster = numbers[CLOSE] / near if near < numbers[CLOSE] else 1.0
    share = min(beyond / FULL, 1.0)
    for i in range(6):
        lower[at + i] = task.rate * error[i]
    shorten(lower, at, numbers[PULL])
    shorten(lower, at + 3, numbers[PULL_TURN])
    for i in range(6):
        lower[at + i] += (1.0 - share) * target[12 + i]
    before, na = vector(task.state, VELOCITY), int(numbers[JOINTS])
    first, dt, inertia = task.A.shape[1] - na, numbers[PERIOD], numbers[MASS] / numbers[PERIOD]
    resistance = numbers[DAMPING] ** 2 * share if beyond > 0.0 else 0.0
    w, q = math.sqrt(inertia + resistance), joint_positions(task.state, na)
    for i in range(na):
        row, weight, change = at + 6 + i, w * numbers[EACH + i], 0.0
        most = numbers[HOMING] / numbers[EACH + i]
        home = min(max(numbers[EACH + 3 * na + i] - q[i], -most), most)
        kept = (inertia * before[first + i] + resistance * home) / (inertia + resistance)
        fastest = numbers[EACH + 2 * na + i] * faster
        if beyond == 0.0:
            change = numbers[EACH + na + i] * dt
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
