"""Poses that are set while they are followed, by any thread, and never jump.

What is set is posted as one object; the tick takes it at its own time. From then on a target goes
along with its twist, and what it would have jumped by is led to zero over a fade: one quintic for
the way, so long that it keeps a speed and an acceleration, and one for the rate and the bend that
the target had before, over its braking time. A change that is small is taken as it is, so that a
stream of targets is followed without a lag.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, entrance, scratch, scratch_matrix
from equipoise.errors import InputError
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import (
    crossed,
    rotation_difference,
    rotation_matrix,
    rotation_rate,
    turned,
)
from equipoise.spatial.numbers import positive, real_list, real_number, real_vector
from equipoise.spatial.poses import rigid, rigid_row
from equipoise.trajectories.base import LIVE, ROW, CompiledTrajectory, instant
from equipoise.trajectories.minimum_jerk import FASTEST, SHARPEST
from equipoise.trajectories.posting import LONG_AGO, counts, faded, seconds

# numbers of a live target: how many were taken, when the last one was, the settings; pose row [12]
# and twist [6] at that time; when the fade began, the three derivatives of what is faded [3, 6],
# how long its way and its rate take, what bounds both; the ball that an arm reaches: its centre,
# the point of the target that has to be inside, its radius, from where on a body cannot help, and
# what bounds the fade of a target outside; then what is posted: its count, pose row, twist, and
# whether the twist is known
TAKEN, SINCE, FADE, HOLD, SMOOTHING = range(5)
BASE, TWIST, FADE_SINCE, OFFSET = 5, 17, 23, 24
SPAN, BRAKE, SPEED, ACCELERATION, TURN, TURN_ACCELERATION = range(42, 48)
CENTRE, POINT, RADIUS, FARTHER, PACE = 48, 51, 54, 55, 56
POSTED = 60
NEW, NEW_TWIST, KNOWN = POSTED + 1, POSTED + 13, POSTED + 19
COUNT = KNOWN + 1

BOUNDS = ("speed", "acceleration", "turn", "turn acceleration")
SMALL, SMALL_TURN = 0.05, 0.2  # [m/s], [rad/s] a change of the wanted speed that need not be faded
NOMINAL = 10.0  # [1/s] rate at which a task makes speeds of distances, to tell what is small
ESTIMATE, ESTIMATE_TURN = 10.0, 40.0  # [m/s^2], [rad/s^2] how fast an estimated twist may change
JUMP = 0.05  # [m] that a target still has to go
AT_REST = [0.0] * 6
BRAKING = 3.95  # greatest bend of the quintic that brakes from a rate of one in a unit of time
LONGEST = 0.01  # [s] of one change of an estimate


@dataclass(frozen=True)
class Ball:
    """What an arm reaches: `point` (3,) of a target [m] lies in it, in its own axes.

    `centre` (3,) [m] in the world, `radius` [m]; from `farther` [m] on no body helps it to get
    there.
    """

    centre: Array
    point: Array
    radius: float
    farther: float


class LiveTarget(CompiledTrajectory):
    """A pose that is set while it is followed; `set` may be called from any thread.

    It rests at `T_world_target` until it is set. With a twist it goes along between two settings;
    without one the twist is estimated from the settings before, smoothed over `smoothing` [s]. If
    none comes for `hold` [s], it comes to rest within as long again. A jump is faded over `fade`
    [s], or over as long as it takes to keep `speed` [m/s], `acceleration` [m/s^2], `turn` [rad/s]
    and `turn_acceleration` [rad/s^2] (none is bounded by default); a change of less than
    5 cm/s or 0.2 rad/s in what is wanted is taken at once.
    One generator follows it: the times of the settings are those of its ticks.
    Raises: `InputError`, `NonFiniteError`, `ShapeError`.
    """

    kind = LIVE

    def __init__(
        self,
        T_world_target: pin.SE3,
        *,
        fade: float = 0.3,
        hold: float = 0.1,
        smoothing: float = 0.01,
        speed: float = math.inf,
        acceleration: float = math.inf,
        turn: float = math.inf,
        turn_acceleration: float = math.inf,
    ) -> None:
        rigid("the pose of a live target", T_world_target)
        numbers = np.zeros(COUNT)
        bounds = (speed, acceleration, turn, turn_acceleration)
        numbers[RADIUS:POSTED] = math.inf
        for place, name, value in zip(range(SPEED, CENTRE), BOUNDS, bounds, strict=True):
            numbers[place] = real_number(f"the {name} of a live target", value, finite=False)
            if not numbers[place] > 0.0:
                raise InputError(f"the {name} of a live target must be positive", given=value)
        for place, name, value in ((FADE, "fade", fade), (HOLD, "hold", hold)):
            numbers[place] = seconds(f"the {name} of a live target", value)
        numbers[SMOOTHING] = real_number("the smoothing of a live target", smoothing)
        if numbers[SMOOTHING] < 0.0:
            raise InputError("the smoothing must not be negative [s]", given=smoothing)
        numbers[SINCE] = numbers[FADE_SINCE] = LONG_AGO
        numbers[BASE:TWIST] = pose_row(T_world_target)
        self._numbers = numbers
        self._posted = self._seen = numbers[POSTED:].copy()

    def set(self, T_world_target: pin.SE3, twist: Array | None = None) -> None:
        """Let the target be here from the next tick on; `twist` (6,) is how it moves.

        That is the velocity [m/s] of its origin and its angular velocity [rad/s], in world axes;
        None: it is estimated. Raises: `InputError`, `NonFiniteError`, `ShapeError`.
        """
        row, moving, known = rigid_row("a live target", T_world_target), AT_REST, 0.0
        if twist is not None:
            moving, known = real_list("the twist of a live target", twist, 6), 1.0
        posted = np.array([next(counts), *row, *moving, known])
        self._posted = posted  # one step: another thread sees the whole of it, or nothing

    def pace_outside(self, ball: Ball, pace: Array) -> None:
        """Let a jump to what is outside of a ball, or back from there, keep a pace (4,).

        That is a speed [m/s], an acceleration [m/s^2], and the same of turns [rad]. Jumps inside
        are as they were.
        """
        self._numbers[CENTRE:POINT] = real_vector("the centre of a ball", ball.centre, 3)
        self._numbers[POINT:RADIUS] = real_vector("the point of a ball", ball.point, 3)
        self._numbers[RADIUS] = positive("the radius of a ball", ball.radius, "m")
        self._numbers[FARTHER] = positive("what is farther than a ball", ball.farther, "m")
        self._numbers[PACE:POSTED] = real_vector("the pace of a live target", pace, 4)

    def post(self) -> None:
        """Hand what was set last to the numbers that the tick works with."""
        posted = self._posted
        if posted is not self._seen:
            self._numbers[POSTED:] = posted
            self._seen = posted

    def work_in(self, numbers: Array) -> None:
        """Keep the numbers from now on in an array (COUNT,) that a kernel works with."""
        numbers[:] = self._numbers
        self._numbers = numbers

    @property
    def numbers(self) -> Array:
        """What the kernel needs (COUNT,), as it is now."""
        return self._numbers.copy()

    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) that a tick at time `t` [s] would follow."""
        numbers, row = self._numbers.copy(), np.empty(ROW)
        numbers[POSTED:] = self._posted
        live_alone(numbers, instant(t), row)
        return row


@compiled
def live_row(n: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write pose row and twist [18] at time t; what is posted and not yet taken is taken first."""
    if n[POSTED] != n[TAKEN]:
        take(n, t)
    shown_row(n, t, row)


@compiled
def shown_row(n: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write the row of what was taken last, with what is still faded."""
    carried(n, t, row)
    apart, turn = scratch(18), scratch_matrix(3, 3)
    if not left_over(n, t, apart):
        return
    for i in range(3):
        row[9 + i] += apart[i]
        row[12 + i] += apart[6 + i]
    rotation_matrix(apart[3], apart[4], apart[5], turn)
    turn_row(turn, row)
    wx, wy, wz = rotation_rate(apart[3], apart[4], apart[5], apart[9], apart[10], apart[11])
    row[15], row[16], row[17] = row[15] + wx, row[16] + wy, row[17] + wz


@compiled
def turn_row(turn: np.ndarray, row: np.ndarray) -> None:
    """Turn the rotation and the angular velocity of a target's row [18] by a matrix [3, 3]."""
    for column in (0, 3, 6, 15):
        x, y, z = row[column], row[column + 1], row[column + 2]
        for i in range(3):
            row[column + i] = turn[i, 0] * x + turn[i, 1] * y + turn[i, 2] * z


@compiled
def carried(n: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write where the target that was taken last has gone with its twist."""
    since, hold = max(t - n[SINCE], 0.0), n[HOLD]
    late = min(max(since - hold, 0.0), hold)  # from the hold on its speed falls to zero
    way, share = min(since, hold) + late - 0.5 * late * late / hold, 1.0 - late / hold
    turn = scratch_matrix(3, 3)
    rotation_matrix(way * n[TWIST + 3], way * n[TWIST + 4], way * n[TWIST + 5], turn)
    for i in range(12):
        row[i] = n[BASE + i]
    for i in range(6):
        row[12 + i] = share * n[TWIST + i]
    for i in range(3):
        row[9 + i] += way * n[TWIST + i]
    for column in (0, 3, 6):
        x, y, z = row[column], row[column + 1], row[column + 2]
        for i in range(3):
            row[column + i] = turn[i, 0] * x + turn[i, 1] * y + turn[i, 2] * z


@compiled
def left_over(n: np.ndarray, t: float, apart: np.ndarray) -> bool:
    """Write value, rate and bend [3 x 6] of what is still faded; False if nothing is."""
    since = max(t - n[FADE_SINCE], 0.0)
    if since >= max(n[SPAN], n[BRAKE]):
        apart[:] = 0.0
        return False
    for i in range(6):
        o, r, a = n[OFFSET + i], n[OFFSET + 6 + i], n[OFFSET + 12 + i]
        way, way_rate, way_bend = faded(o, 0.0, 0.0, n[SPAN], since)
        left, left_rate, left_bend = faded(0.0, r, a, n[BRAKE], since)
        apart[i], apart[6 + i] = way + left, way_rate + left_rate
        apart[12 + i] = way_bend + left_bend
    return True


@compiled
def take(n: np.ndarray, t: float) -> None:
    """Take what was posted as the target from time t on."""
    shown, before, apart = scratch(18), scratch(18), scratch(18)
    n[TAKEN] = n[POSTED]
    shown_row(n, t, shown)
    carried(n, t, before)
    left_over(n, t, apart)
    if n[KNOWN] == 0.0:
        estimate(n, t)
    for i in range(18):
        n[BASE + i] = n[NEW + i]  # pose and twist
    n[SINCE] = t
    jump, turn = 0.0, 0.0
    rx, ry, rz = rotation_difference(before, n[BASE:TWIST])
    turned_by = (rx, ry, rz)
    for i in range(3):
        change = before[12 + i] - n[TWIST + i] + NOMINAL * (before[9 + i] - n[BASE + 9 + i])
        jump += change * change
        change = before[15 + i] - n[TWIST + 3 + i] + NOMINAL * turned_by[i]
        turn += change * change
    if jump > SMALL * SMALL or turn > SMALL_TURN * SMALL_TURN:
        fade_from(n, t, shown, apart)


@compiled
def is_beyond(n: np.ndarray, row: np.ndarray, radius: float) -> bool:
    """Tell whether the point of a target's row is farther from the centre of its ball."""
    x, y, z = turned(row, n[POINT], n[POINT + 1], n[POINT + 2])
    x, y, z = row[9] + x - n[CENTRE], row[10] + y - n[CENTRE + 1], row[11] + z - n[CENTRE + 2]
    return x * x + y * y + z * z > radius * radius


@compiled
def is_sent_beyond(n: np.ndarray, row: np.ndarray) -> bool:
    """Tell whether a target at `row` jumps to where no body helps to get."""
    square = 0.0
    for i in range(9, 12):
        square += (n[BASE + i] - row[i]) ** 2
    return square > JUMP * JUMP and is_beyond(n, n[BASE:TWIST], n[FARTHER])


@compiled
def estimate(n: np.ndarray, t: float) -> None:
    """Write the twist of what was posted, from how far it is from what was taken before."""
    gap = t - n[SINCE]
    if not 0.0 < gap <= n[HOLD]:
        for i in range(6):
            n[NEW_TWIST + i] = 0.0
        return
    rx, ry, rz = rotation_difference(n[NEW:NEW_TWIST], n[BASE:TWIST])
    turned_by, share = (rx, ry, rz), gap / (gap + n[SMOOTHING])
    for i in range(3):
        raw = (n[NEW + 9 + i] - n[BASE + 9 + i]) / gap
        most = ESTIMATE * min(gap, LONGEST)
        change = share * (raw - n[TWIST + i])
        n[NEW_TWIST + i] = n[TWIST + i] + min(max(change, -most), most)
        most = ESTIMATE_TURN * min(gap, LONGEST)
        change = share * (turned_by[i] / gap - n[TWIST + 3 + i])
        n[NEW_TWIST + 3 + i] = n[TWIST + 3 + i] + min(max(change, -most), most)


@compiled
def fade_from(n: np.ndarray, t: float, shown: np.ndarray, apart: np.ndarray) -> None:
    """Begin a fade, from where the target was `shown` [18] to where it was taken."""
    n[FADE_SINCE] = t
    x, y, z = rotation_difference(shown, n[BASE:TWIST])
    n[OFFSET + 3], n[OFFSET + 4], n[OFFSET + 5] = x, y, z
    for i in range(3):
        n[OFFSET + i] = shown[9 + i] - n[BASE + 9 + i]
        n[OFFSET + 6 + i] = shown[12 + i] - n[TWIST + i]
    for i in range(6):
        n[OFFSET + 12 + i] = apart[12 + i]
    turn, angle = scratch_matrix(3, 3), math.sqrt(x * x + y * y + z * z)
    rotation_matrix(x, y, z, turn)
    w = scratch(3)
    for i in range(3):
        w[i] = shown[15 + i]
        for k in range(3):
            w[i] -= turn[i, k] * n[TWIST + 3 + k]
    # the rate of the rotation vector, that is the inverse of `rotation_rate`
    g = 1.0 / 12.0
    if angle > 1e-4:
        half = 0.5 * angle
        g = (1.0 - half * math.cos(half) / math.sin(half)) / (angle * angle)
    ax, ay, az = crossed(x, y, z, w[0], w[1], w[2])
    bx, by, bz = crossed(x, y, z, ax, ay, az)
    n[OFFSET + 9] = w[0] - 0.5 * ax + g * bx
    n[OFFSET + 10] = w[1] - 0.5 * ay + g * by
    n[OFFSET + 11] = w[2] - 0.5 * az + g * bz
    n[SPAN] = n[BRAKE] = n[FADE]
    paced = is_beyond(n, n[BASE:TWIST], n[RADIUS]) or is_beyond(n, shown, n[RADIUS])
    for part in range(2):  # of place, of rotation
        at, fastest, change = OFFSET + 3 * part, n[SPEED + 2 * part], n[ACCELERATION + 2 * part]
        if paced:
            fastest = min(fastest, n[PACE + 2 * part])
            change = min(change, n[PACE + 2 * part + 1])
        far = math.sqrt(n[at] ** 2 + n[at + 1] ** 2 + n[at + 2] ** 2)
        rate = math.sqrt(n[at + 6] ** 2 + n[at + 7] ** 2 + n[at + 8] ** 2)
        n[SPAN] = max(n[SPAN], FASTEST * far / fastest, math.sqrt(SHARPEST * far / change))
        n[BRAKE] = max(n[BRAKE], BRAKING * rate / change)


@entrance
def live_alone(numbers: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write the row of one live target."""
    live_row(numbers, t, row)
