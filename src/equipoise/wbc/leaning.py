"""What hands press leans the robot: balance moves with it, and a force waits until it is borne.

A hand that presses a wall with F at the height z moves the point of zero moment by F z / (m g): 17
cm for 70 N at 1.33 m and HRP-2. So the polygon of a balance task that `leans` moves along, so
slowly that speeding up takes a quarter of its margin, and what is asked of the hands goes to what
is wanted only as far as the point of zero moment of the reference at rest stays inside of it. On
the way back a force waits for the robot likewise.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.contacts.program import contact_rows
from equipoise.control.passivity.memory import (
    AT,
    J_PHI,
    LAM_REF,
    REGULATED,
    REGULATED_COUNT,
    ROW_COUNT,
    leading_rows,
)
from equipoise.control.passivity.memory import FLAGS as LAW_FLAGS
from equipoise.kinematics.kernels import COM, JOINTS
from equipoise.kinematics.tree import BELOW
from equipoise.motion.kernels import MotionBlocks
from equipoise.motion.memory import FIRST, KIND, NUMBERS, RATES
from equipoise.spatial.kernels import turned
from equipoise.tasks.com_polygon import (
    EDGES,
    GRAVITY,
    HEIGHT,
    LEAN_X,
    LEANS,
    LIFTED,
    MARGIN,
    room_at,
)
from equipoise.tasks.floor_support import LEAN_X as SUPPORT_LEAN_X
from equipoise.tasks.view import COM_POLYGON, FLOOR_SUPPORT
from equipoise.wbc.memory import ASKED_FORCES, WANTED_OF

LEAST_MARGIN = 0.005  # [m] a polygon with less of a margin moves as one with this
SPARE = 0.1  # of the margin that a force may use; without, it would be reached in the limit only


@compiled
def lean(m: MotionBlocks, contacts: Block, law: Block, meeting: Block, dt: float) -> None:
    """Turn what is wanted of the hands, in the law, into what is asked; lean the balance tasks.

    `contacts` are the law's; their rows at the reference are left in its J until it runs.
    """
    kind, first = integers(m.tasks, KIND), integers(m.tasks, FIRST)
    pool, rates = vector(m.tasks, NUMBERS), vector(m.tasks, RATES)
    count = integers(law, LAW_FLAGS)[REGULATED_COUNT]
    wanted_of, asked = integers(meeting, WANTED_OF), vector(meeting, ASKED_FORCES)
    lam, before = vector(law, LAM_REF), scratch(count)
    for i in range(count):
        if not math.isfinite(lam[i]):
            return  # the supervisor is about to see it; nothing is remembered of it
        before[i] = asked[wanted_of[i]]
    rows = integers(law, LAW_FLAGS)[ROW_COUNT]
    contact_rows(m.tree, m.state, contacts, leading_rows(law, J_PHI, rows), integers(law, AT))
    now, then, nothing = scratch(3), scratch(3), scratch(3)
    nothing[:] = 0.0
    for k in range(kind.shape[0]):
        numbers = pool[first[k] : first[k + 1]]
        if kind[k] == COM_POLYGON and numbers[LEANS]:
            lean_of(m, law, numbers[HEIGHT], before, now)
            share = borne_share(m, numbers, nothing, now, SPARE * numbers[MARGIN])
            if share < 1.0:  # the reference was moved from where it bore this
                for i in range(count):
                    before[i] *= share
                lean_of(m, law, numbers[HEIGHT], before, now)
            lean_of(m, law, numbers[HEIGHT], lam[:count], then)
            move_polygon(m, numbers, rates[k], then, dt)
            share = borne_share(m, numbers, now, then, SPARE * numbers[MARGIN])
            for i in range(count):
                lam[i] = before[i] + share * (lam[i] - before[i])
    for k in range(kind.shape[0]):
        numbers = pool[first[k] : first[k + 1]]
        if kind[k] == FLOOR_SUPPORT and numbers[LEANS]:
            lean_of(m, law, numbers[HEIGHT], lam[:count], then)
            for i in range(3):
                numbers[SUPPORT_LEAN_X + i] = then[i]
    asked[:] = 0.0  # of what does not hold nothing is asked
    for i in range(count):
        asked[wanted_of[i]] = lam[i]


@compiled
def lean_of(m: MotionBlocks, law: Block, height: float, lam: np.ndarray, out: np.ndarray) -> None:
    """Write how far the multipliers `lam` of the regulated rows make the robot lean: see `room_at`.

    Their wrench on the base is that of the rows' columns of the base.
    """
    J = leading_rows(law, J_PHI, integers(law, LAW_FLAGS)[ROW_COUNT])
    row, base = integers(law, REGULATED), matrix(m.state, JOINTS)[1]
    w = scratch(6)
    for c in range(6):
        w[c] = 0.0
        for i in range(lam.shape[0]):
            w[c] += J[row[i], c] * lam[i]
    Fx, Fy, Fz = turned(base, w[0], w[1], w[2])
    Mx, My, _ = turned(base, w[3], w[4], w[5])
    x, y, z = base[9], base[10], base[11] - height
    Mx += y * Fz - z * Fy
    My += z * Fx - x * Fz
    weight = GRAVITY * vector(m.tree, BELOW)[0]
    out[0], out[1], out[2] = -My / weight, Mx / weight, Fz / weight


@compiled
def move_polygon(
    m: MotionBlocks, numbers: np.ndarray, rate: float, then: np.ndarray, dt: float
) -> None:
    """Move a polygon towards `then`, no faster than a quarter of its margin bears.

    The centre of mass comes along by speed times `rate` [m/s^2] at most, and each m/s^2 moves the
    point of zero moment by its height over g. It is that far behind, speed over `rate`: an edge
    that is farther off may come so near at once.
    """
    height = max(vector(m.state, COM)[2] - numbers[HEIGHT], 0.1)
    margin = max(numbers[MARGIN], LEAST_MARGIN)
    speed = margin * GRAVITY / (4.0 * height * max(rate, 1e-3))
    x, y = then[0] - numbers[LEAN_X], then[1] - numbers[LEAN_X + 1]
    far, step = math.sqrt(x * x + y * y), dt * speed
    now = numbers[LEAN_X : LIFTED + 1]
    part = borne_share(m, numbers, now, then, -speed / max(rate, 1e-3))
    part = max(part, 1.0 if far <= step else step / far)
    for i in range(3):
        numbers[LEAN_X + i] += part * (then[i] - numbers[LEAN_X + i])


@compiled
def borne_share(
    m: MotionBlocks, numbers: np.ndarray, now: np.ndarray, then: np.ndarray, spare: float
) -> float:
    """Return how far from `now` to `then` hands may give, from 0 to 1, at the reference.

    The centre of mass may be `spare` [m] beyond the edges that are moved in.
    """
    com, share = vector(m.state, COM), 1.0
    for i in range((numbers.shape[0] - EDGES) // 3):
        here, there = room_at(numbers, i, com, now) + spare, room_at(numbers, i, com, then) + spare
        if there < here and there < 0.0:
            share = min(share, max(here, 0.0) / (here - there))
    return share
