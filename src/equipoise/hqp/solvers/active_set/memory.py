"""The two parts of a workspace that the solver works on, and the numbers of their arrays.

The part `rows` is the problem. Who builds it fills `A` [m, n], `lower` [m], `upper` [m] every tick,
and once, when it is laid out: `ends` [levels], the number of rows in levels 0..i; `first`, `last`
[m], columns of a row outside first..last-1 are zero; `single` [m], the only column in which a row
may be other than zero, else -1.

The part `search` belongs to the solver. Before a call `counts` [m] may be written: 0 leaves a row
out, as if it had no bounds (ones after `Workspace` was prepared with `start_search`). After it `v`
[n] is the answer, `numbers` say how it came about, and `judge` fills `w` [m], `slack` [levels] and
`active` [m]. What `SEARCH_MEMORY` names is kept for the next tick; zeros there are a cold start.
"""

from __future__ import annotations

from equipoise.compiled.workspace import Arrays, Shape

ROWS = Arrays(
    ("A", "lower", "upper", "ends", "first", "last", "single"),
    frozenset({"ends", "first", "last", "single"}),
)
A_ROWS, LOWER, UPPER, ENDS, FIRST, LAST, SINGLE = range(7)

_FLOATS = (
    "v",  # [n] the answer, and while searching the point at hand
    "last_v",  # [n] memory: the last answer
    "w",  # [m] violation of each row
    "slack",  # [levels] norm of the violation of each level
    "point",  # [n] where the levels solved so far left us
    "next_v",  # [n] optimum of the working problem
    "step",  # [n] from v to there
    "value",  # [m] A v
    "next_value",  # [m] A next_v
    "rate",  # [m] A step
    "norm",  # [m] length of a row, where it was needed
    "basis",  # [n, n] orthonormal rows that span what is still free
    "white",  # [n, n] the same span, orthonormal in the columns of a goal
    "reduced",  # [m, n] rows in coordinates of a basis
    "factor",  # [m, n] working rows by place, eliminated
    "reflectors",  # [n, n] of that elimination
    "inverse",  # [n, n] of the triangle of soft working rows
    "mix",  # [m, n] dependent working rows as sums of independent ones
    "square",  # [n, n] a symmetric positive definite matrix, then its Cholesky factor
    "goal",  # [n] coordinates of the goal
    "toward",  # [n] the same, reflected
    "along",  # [n] coordinates along the reflectors
    "turned",  # [n] coordinates turned back
    "multiplier",  # [n] of held rows by place
    "noise",  # [n] rounding of these
    "share",  # [n] of held rows in another one
    "rest",  # [m] what working rows have to reach, by place
    "left",  # [m] square of what is left of working rows, by place
    "once_left",  # [m] the same when last summed up
    "miss",  # [m] violation of soft working rows, by place
    "shake",  # [m] rounding of these
)
_INTEGERS = (
    "numbers",  # as named below
    "counts",  # [m] 0: leave the row out
    "active",  # [m] -1 lower, +1 upper, 2 equality, 0 inactive
    "sides",  # [levels + 1, m] memory: sides at the optimum of each level, last the least norm
    "met",  # [levels + 1] memory: how many ticks a level has been met, up to MET_LONG
    "order",  # [m] memory: independent equalities in their order of elimination, then -1
    "known",  # [1] memory: 0 before the first answer
    "role",  # [m] as named below
    "side",  # [m] bound at which a row works: +1 upper, -1 lower, 2 equality, 0 not working
    "place",  # [m] row at a working place
    "fresh",  # [m] basis for which a row was reduced last
    "independent",  # [m] 1: an equality that was eliminated
    "reach",  # [n] column at which a reflector ends
    "begin",  # [m or n] support of working rows by place, or of rows of a basis
    "finish",  # [m or n]
)
SEARCH = Arrays(_FLOATS + _INTEGERS, frozenset(_INTEGERS))
(
    V, LAST_V, W, SLACK, POINT, NEXT_V, STEP, VALUE, NEXT_VALUE, RATE, NORM, BASIS, WHITE, REDUCED,
    FACTOR, REFLECTORS, INVERSE, MIX, SQUARE, GOAL, TOWARD, ALONG, TURNED, MULTIPLIER, NOISE, SHARE,
    REST, LEFT, ONCE_LEFT, MISS, SHAKE, NUMBERS, COUNTS, ACTIVE, SIDES, MET, ORDER, KNOWN, ROLE,
    SIDE, PLACE, FRESH, INDEPENDENT, REACH, BEGIN, FINISH,
) = range(len(SEARCH.names))  # fmt: skip
SEARCH_MEMORY = ("last_v", "sides", "met", "order", "known")

# numbers: working problems solved, optima in a row that were found together (1: none), times that
# the search was taken apart, free directions, rows held, the basis that `reduced` is for
WORKS, PASSES, RESTARTS, FREE, HELD, BASIS_NUMBER, RELEARN = range(7)
NUMBERS_KEPT = 8

# roles: OUT rows have no bounds or do not count; those of a LATER level are not looked at yet; HARD
# rows have to be met; OWN rows belong to the level at hand; FIXED ones are determined
OUT, LATER, HARD, OWN, FIXED = range(5)
EQUALITY = 2  # a side

# what `solve` returns
SOLVED, ITERATION_LIMIT, FAILED = range(3)

# What counts as none. A row of which less than DEPENDENT of its length is left depends on others:
# at the root of the machine precision either answer is right to that root, since an answer that
# leaves such a row out breaks it by this share, and one that does not loses as many digits. The
# others are shares of (length of a row) (size of v).
DEPENDENT = 1e-8
SAFE_PIVOT = 1e-4  # the least share that may be left in an elimination in remembered order
MET_TOLERANCE = 1e-8  # by which rows that depend on others may be missed
FEASIBILITY = 1e-11  # by which inequalities may be missed that do not, and count as met
ROUNDING = 1e-14
MET_LONG = 20  # ticks after which a level that was short is merged with the next again
SMALLEST = 1e-150  # a size below it counts as this one


def rows_shapes(m: int, n: int, levels: int) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of the part `rows` for m rows, n unknowns and a number of levels."""
    return ROWS.shapes(A=(m, n), lower=m, upper=m, ends=levels, first=m, last=m, single=m)


def search_shapes(m: int, n: int, levels: int) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of the part `search` for m rows, n unknowns and a number of levels."""
    of_columns = {
        "v", "last_v", "point", "next_v", "step", "goal", "toward", "along", "turned", "multiplier",
        "noise", "share", "reach",
    }  # fmt: skip
    shapes: dict[str, int | Shape] = {
        "numbers": NUMBERS_KEPT,
        "known": 1,
        "slack": levels,
        "met": levels + 1,
        "sides": (levels + 1, m),
    }
    shapes |= dict.fromkeys(("basis", "white", "reflectors", "inverse", "square"), (n, n))
    shapes |= dict.fromkeys(("reduced", "factor", "mix"), (m, n))
    shapes |= dict.fromkeys(("begin", "finish"), max(m, n))
    for name in SEARCH.names:
        shapes.setdefault(name, n if name in of_columns else m)
    return SEARCH.shapes(**shapes)
