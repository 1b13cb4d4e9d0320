"""The part of a workspace in which motion and law meet."""

from __future__ import annotations

from equipoise.compiled.workspace import Arrays, Shape

MEETING = Arrays(
    ("numbers", "wanted_of", "flags", "fastest", "asked_forces"), frozenset({"wanted_of", "flags"})
)
NUMBERS, WANTED_OF, FLAGS, FASTEST, ASKED_FORCES = range(len(MEETING.names))
# entries of `numbers`: the period [s], and how far posture [rad or m] and tilt [rad] may be from
# the reference before the supervisor has to look; `fastest` [na]: the speed of each joint likewise
PERIOD, POSTURE_ERROR, TILT = range(3)
# entries of `flags`: whether tasks fade, and whether balance leans into what hands press
FADING, LEANING = range(2)


def meeting_shapes(regulated: int, joints: int) -> list[tuple[str, Shape, bool]]:
    """Return the arrays.

    `wanted_of` [k] is the scalar that each regulated row that holds wants, `asked_forces` [k] what
    was asked of each scalar at the last tick.
    """
    k = max(regulated, 1)
    return MEETING.shapes(numbers=3, wanted_of=k, flags=2, fastest=joints, asked_forces=k)
