"""What a frame remembers of a target out of its reach: whether it waits, and how calm it is.

Its `numbers` are those of a `Reach`; some of them are its memory from tick to tick.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, inlined
from equipoise.compiled.workspace import matrix, vector
from equipoise.kinematics.kernels import FRAMES, VELOCITY
from equipoise.kinematics.kernels import JOINTS as PLACES
from equipoise.spatial.kernels import crossed, turned
from equipoise.tasks.view import TaskView
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
# of reach, or so many times what its rate takes; as many times as long while it catches up
PATIENCE, FOLDS, PATIENT = 0.25, 4.0, 16.0


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
    if out and numbers[CALM] < 1.0:
        out = near > FOLLOWED  # what is followed is not out of reach
    if task.live.shape[0] and is_sent_beyond(task.live, task.target):
        out = True  # it will be: arms go there before legs
    numbers[BEHIND] += dt if numbers[LATE] == 0.0 else dt / PATIENT
    if beyond == 0.0:
        numbers[BEHIND] = 0.0
    if not out and nearly and near > FOLLOWED:
        x, y, z = there[0] - hand[0], there[1] - hand[1], there[2] - hand[2]
        out = numbers[CALM] == 1.0 or mobility(task, x, y, z) < STRETCHED
    swinging = swings(task) and numbers[CALM] == 0.0
    stuck = numbers[BEHIND] > max(PATIENCE, FOLDS / task.rate) or swinging
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
