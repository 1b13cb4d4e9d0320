"""The laws by which joints of a description follow others, whose leaders follow nobody."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from equipoise.errors import RobotFileError, quoted


class Law(NamedTuple):
    """Joint `follower` is at `ratio` times the coordinate of `leader` and `offset`; by name."""

    follower: str
    leader: str
    ratio: float
    offset: float


def resolved(laws: Iterable[Law]) -> list[Law]:
    """Return the laws with leaders that follow nobody.

    Raises: RobotFileError for joints that follow each other in a circle.
    """
    by_name = {law.follower: law for law in laws}
    found = []
    for law in by_name.values():
        seen = [law.follower]
        while law.leader in by_name:
            if law.leader in seen:
                raise RobotFileError(
                    "joints follow each other in a circle",
                    given=", ".join(map(quoted, seen)),
                    remedy="Let one of them follow nobody: take its <mimic> or equality out",
                )
            above = by_name[law.leader]
            seen.append(above.follower)
            offset = law.ratio * above.offset + law.offset
            law = Law(law.follower, above.leader, law.ratio * above.ratio, offset)
        found.append(law)
    return found
