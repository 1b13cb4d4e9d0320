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
from equipoise.compiled.workspace import matrix, vector
from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.kinematics.kernels import FRAMES, VELOCITY
from equipoise.kinematics.kernels import JOINTS as PLACES
from equipoise.robots import Robot, require_robot
from equipoise.robots.arm_span import ArmSpan
from equipoise.spatial import Array
from equipoise.spatial.kernels import crossed, turned
from equipoise.spatial.numbers import (
    not_negative,
    positive,
    real_array,
    real_number,
    real_vector,
    require_period,
)
from equipoise.tasks.view import TaskView, joint_positions
from equipoise.trajectories.live import is_sent_beyond

# entries of the numbers; then for each joint its weight, its change, its fastest, its home
PULL, PULL_TURN, DAMPING, MASS, PERIOD, JOINTS, CLOSE, HOMING = range(8)
# the shoulder (a joint, or -1: always calm), where it is at the start (3,), the wrist in the frame
# (3,), from where on it may be out of reach, and surely is; and what is
# remembered: how calm joints are kept, from 1 to 0, whether the frame was left behind and has not
# caught up, by how much it misses what is out of reach, for how long it has been behind, how far at
# most where that is not for the length of its arm, whether trunk and legs still come home, and
# whether it was called back; after the four of each joint its speed in the tick before
SHOULDER, CENTRE, WRIST, NEARLY, OUT = 8, 9, 12, 15, 16
CALM, LATE, MISSED, BEHIND, WORST, SLOW, CALLED = range(17, 24)
EACH = 24
FREE = 0.02  # [m] from the target nothing is damped
FULL = 0.1  # [m] beyond which a target is not followed in its speed, and the damping is whole
LEVER = 0.2  # [m] a turn counts as much as a way of this length for each radian
FOLLOWED = 0.005  # [m] within which a frame follows its target well
STRETCHED = 0.1  # share of its usual mobility, squared, below which an arm is stretched that way
HEAVY = 8.0  # weight of a joint from which on it is trunk or leg
HOME_RATE = 2.0  # [1/s] with which heavy joints may come home: what they change their speed by
RESTS = 0.01  # [rad/s]
SWING = 200.0  # [rad/s^2] of a joint that swings: where targets are in reach 30 to 90 are seen
LEAVING = 2.0  # [s] in which calm joints become free again
# [s] for which a frame may be behind a target that its arm could get to, before that counts as out
# of reach; as many times as long while it catches up
PATIENCE, PATIENT = 0.25, 16.0


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
    target's wrist is farther from where the shoulder was at the start than the second of `edges`
    [m]; or than the first, with the frame more than 5 mm behind and the arm stretched that way; or when the frame was 2 cm behind for 0.25 s, or a joint swings. It
    ends when the target is back and the frame follows it well, or the arm is bent. Before and after
    the target is followed exactly.
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


@compiled
def remember(task: TaskView, near: float, beyond: float) -> float:
    """Remember whether the target is out of reach and how calm joints are; return how far out.

    That is from 0, at the edge of the reach, to 1.
    """
    numbers, T, dt = task.numbers, matrix(task.state, FRAMES)[task.frame], task.numbers[PERIOD]
    s, start = matrix(task.state, PLACES)[int(numbers[SHOULDER])], numbers[CENTRE:WRIST]
    hand, there = wrist_at(T, numbers), wrist_at(task.target, numbers)
    reached, away = distance(hand, s[9:12]), distance(there, start)
    nearly, out = away > numbers[NEARLY], away > numbers[OUT]
    if task.live.shape[0] and is_sent_beyond(task.live):
        out = True  # it will be: arms go there before legs
    numbers[BEHIND] += dt if numbers[LATE] == 0.0 else dt / PATIENT
    if beyond == 0.0:
        numbers[BEHIND] = 0.0
    if not out and nearly and near > FOLLOWED:
        x, y, z = there[0] - hand[0], there[1] - hand[1], there[2] - hand[2]
        out = numbers[CALM] == 1.0 or mobility(task, x, y, z) < STRETCHED
    swinging = swings(task) and numbers[CALM] == 0.0
    stuck = numbers[BEHIND] > PATIENCE or swinging
    if out or stuck:
        numbers[CALM] = numbers[LATE] = numbers[SLOW] = 1.0
    if out:
        numbers[WORST] = numbers[BEHIND] = 0.0
    elif stuck or numbers[WORST] > 0.0:
        numbers[WORST] = max(numbers[WORST], near, FREE)
    well = near < FOLLOWED
    if numbers[WORST] > 0.0:
        well = well or near < 0.5 * numbers[WORST]
        if not well:
            numbers[CALM] = 1.0
    else:
        well = well or reached < numbers[NEARLY]
    if not (out or nearly or stuck) and well:
        numbers[CALM] = max(numbers[CALM] - dt / LEAVING, 0.0)
    numbers[CALLED] = 0.0 if out or nearly else 1.0
    if numbers[CALM] == 0.0:
        numbers[WORST] = 0.0
        if beyond == 0.0:
            numbers[LATE] = 0.0
        if numbers[SLOW] != 0.0 and near < FOLLOWED and is_at_rest(task):
            numbers[SLOW] = 0.0
    numbers[MISSED] = near if numbers[CALM] == 1.0 and near > FOLLOWED else 0.0
    return min(max((away - numbers[NEARLY]) / FULL, 0.0), 1.0)


@compiled
def is_at_rest(task: TaskView) -> bool:
    """Tell whether no heavy joint moves."""
    v, na = vector(task.state, VELOCITY), int(task.numbers[JOINTS])
    first = v.shape[0] - na
    for i in range(na):
        if task.numbers[EACH + i] > HEAVY and abs(v[first + i]) > RESTS:
            return False
    return True


@compiled
def swings(task: TaskView) -> bool:
    """Tell whether a joint changed its speed as fast as `bound_swings` lets it; note the speeds."""
    numbers, v, na = task.numbers, vector(task.state, VELOCITY), int(task.numbers[JOINTS])
    first, last, most = v.shape[0] - na, EACH + 4 * na, SWING * numbers[PERIOD]
    moving, found = False, False
    for i in range(na):
        moving = moving or numbers[last + i] != 0.0
        found = found or abs(v[first + i] - numbers[last + i]) > 0.999 * most
        numbers[last + i] = v[first + i]
    return moving and found


@inlined
def wrist_at(T: np.ndarray, numbers: np.ndarray) -> tuple[float, float, float]:
    """Return where the wrist of a frame that is at T [12] is."""
    x, y, z = turned(T, numbers[WRIST], numbers[WRIST + 1], numbers[WRIST + 2])
    return T[9] + x, T[10] + y, T[11] + z


@inlined
def distance(p: tuple[float, float, float], o: np.ndarray) -> float:
    """Return how far a point is from another one [3]."""
    return math.sqrt((p[0] - o[0]) ** 2 + (p[1] - o[1]) ** 2 + (p[2] - o[2]) ** 2)


@compiled
def mobility(task: TaskView, x: float, y: float, z: float) -> float:
    """Return how well light joints move the wrist along (x, y, z): 1 for as well as any other way.

    It is |J^T n|^2 over a third of |J|^2, in which joints count by their weights.
    """
    numbers, A, at, na = task.numbers, task.A, task.at, int(task.numbers[JOINTS])
    T, first = matrix(task.state, FRAMES)[task.frame], A.shape[1] - na
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return 1.0
    nx, ny, nz = x / length, y / length, z / length
    rx, ry, rz = turned(T, numbers[WRIST], numbers[WRIST + 1], numbers[WRIST + 2])
    along, whole = 0.0, 0.0
    for i in range(na):
        c, w = first + i, numbers[EACH + i]
        x, y, z = crossed(A[at + 3, c], A[at + 4, c], A[at + 5, c], rx, ry, rz)
        x, y, z = (A[at, c] + x) / w, (A[at + 1, c] + y) / w, (A[at + 2, c] + z) / w
        along += (nx * x + ny * y + nz * z) ** 2
        whole += x * x + y * y + z * z
    return 3.0 * along / whole if whole > 0.0 else 0.0


@inlined
def shorten(x: np.ndarray, at: int, longest: float) -> None:
    """Shorten the three numbers x[at : at + 3] to a length, keeping their direction."""
    length = math.sqrt(x[at] ** 2 + x[at + 1] ** 2 + x[at + 2] ** 2)
    if length > longest:
        for i in range(at, at + 3):
            x[i] *= longest / length
