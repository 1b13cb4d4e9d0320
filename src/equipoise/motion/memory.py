"""The part of a workspace in which the tasks of a motion stand, and what a blend of them needs."""

from __future__ import annotations

from equipoise.compiled.workspace import Arrays, Shape

TASKS = Arrays(
    ("rates", "numbers", "contact_rate", "window", "fades", "weights", "shares", "thresholds",
     "blended", "v_ref", "row_weight", "kind", "frame", "target", "first", "at", "pairs",
     "contact_at", "contact_held", "fade_of", "row_constant", "flags", "clock", "row_ease",
     "row_slope", "row_cap"),
    frozenset({"kind", "frame", "target", "first", "at", "pairs", "contact_at", "contact_held",
               "fade_of", "row_constant", "flags"}),
)  # fmt: skip
(RATES, NUMBERS, CONTACT_RATE, WINDOW, FADES, WEIGHTS, SHARES, THRESHOLDS, BLENDED, V_REF,
 ROW_WEIGHT, KIND, FRAME, TARGET, FIRST, AT, PAIRS_PART, CONTACT_AT, CONTACT_HELD, FADE_OF,
 ROW_CONSTANT, FLAGS, CLOCK, ROW_EASE, ROW_SLOPE, ROW_CAP) = range(len(TASKS.names))  # fmt: skip

# entries of `flags`: whether a task needs the centre of mass; which part of the workspace the first
# search is; how many searches there are, and how many the last tick used; how it went; whether a
# task needs the velocity of the tick before, and whether the motion that it makes; whether any
# task has another weight than 1; whether any has an ease
(NEEDS_COM, SEARCHES_FROM, SEARCHES, USED, STATUS, NEEDS_BEFORE, NEEDS_MOTION, WEIGHED,
 EASED) = range(9)  # fmt: skip

# entries of `clock`: the rate at which the time of the targets goes [1], that time [s], and what
# the governor is told (see `motion.governor`): errors of frames [m, rad] and of the posture [rad]
# at which it begins to slow and at which it stops, how fast the rate may fall and rise [1/s]; and
# the period of the ticks [s]
(CLOCK_RATE, CLOCK_TIME, GOVERNED, WAY_FREE, WAY_STOP, TURN_FREE, TURN_STOP, POSTURE_FREE,
 POSTURE_STOP, FALL, RISE, TICK) = range(12)  # fmt: skip
CLOCK_SIZE = 12


def task_shapes(
    tasks: int, numbers: int, contacts: int, rows: int, fades: int, nv: int
) -> list[tuple[str, Shape, bool]]:
    """Return the arrays.

    Task k has the `numbers[first[k] : first[k + 1]]` and its rows from `at[k]` on; an avoidance
    task its distances in the part `pairs[k]`. Contact i of level 0 has its rows from
    `contact_at[i]` on, is drawn back with `contact_rate[i]` [1/s] and holds from `window[i, 0]` to
    `window[i, 1]` [s]. `fades` [f, 3] and `weights` [f] belong to what fades, `fade_of` [rows] is
    the fade of a row or -1, `row_weight` [rows] its weight and `row_constant` [rows] whether A of
    it was written once, with its weight. `row_ease` [rows] is the ease of a row [1/s] or infinite,
    `row_slope` how its bound falls over the distance [1/s], `row_cap` where that ends. `shares`
    [f + 1] are those of the parts of a blend, `thresholds` the least weight with which something
    counts in them.
    """
    k, c, f = max(tasks, 1), max(contacts, 1), max(fades, 1)
    return TASKS.shapes(
        rates=k, numbers=max(numbers, 1), contact_rate=c, window=(c, 2), fades=(f, 3), weights=f,
        shares=f + 1, thresholds=f + 1, blended=nv, v_ref=nv, row_weight=max(rows, 1), kind=k,
        frame=k, target=k, first=k + 1, at=k, pairs=k, contact_at=c, contact_held=c,
        fade_of=max(rows, 1), row_constant=max(rows, 1), flags=9, clock=CLOCK_SIZE,
        row_ease=max(rows, 1), row_slope=max(rows, 1), row_cap=max(rows, 1),
    )  # fmt: skip
