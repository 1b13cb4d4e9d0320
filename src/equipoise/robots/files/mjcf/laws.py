"""Reads which joints of an MJCF follow another one: affine equality constraints of joints."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from equipoise.robots.files.finding import WARNING, Finding
from equipoise.robots.files.laws import Law, resolved
from equipoise.robots.files.mjcf.compiled import joint_name
from equipoise.robots.files.mjcf.limits import effort_of

EQUALITIES = ("connect", "weld", "joint", "tendon", "flex", "flexvert", "flexstrain")
JOINT = EQUALITIES.index("joint")


class Laws(NamedTuple):
    """`laws` of joints that follow others; where joints are `held` by one alone; `unused` ones."""

    laws: list[Law]
    held: dict[int, float]
    unused: list[int]


def read_laws(compiled: Any, locked: set[int]) -> Laws:
    """Return what the equality constraints of joints say.

    MuJoCo's law is `q1 - q1_0 = c0 + c1 (q2 - q2_0)` with the reference positions q_0. The first
    joint follows, unless only that one has an actuator; but who hangs on another never leads it.
    A follower that is in `locked` follows nothing; of two laws for one joint the first counts.
    Raises: RobotFileError for joints that follow each other in a circle.
    """
    laws: dict[str, Law] = {}
    held: dict[int, float] = {}
    unused: list[int] = []
    for k in range(compiled.neq):
        if not _is_affine(compiled, k):
            unused += [k] if compiled.eq_active0[k] else []
            continue
        one, other = int(compiled.eq_obj1id[k]), int(compiled.eq_obj2id[k])
        c0, c1 = (float(c) for c in compiled.eq_data[k, :2])
        if other < 0 or c1 == 0.0:
            held.setdefault(one, _reference(compiled, one) + c0)
            continue
        offset = _reference(compiled, one) + c0 - c1 * _reference(compiled, other)
        drives = effort_of(compiled, one)[1] and not effort_of(compiled, other)[1]
        if (drives and not _hangs_on(compiled, one, other)) or _hangs_on(compiled, other, one):
            one, other, c1, offset = other, one, 1.0 / c1, -offset / c1
        follower = joint_name(compiled, one)
        if follower in laws:
            unused.append(k)
        elif one not in locked:
            laws[follower] = Law(follower, joint_name(compiled, other), c1, offset)
    return Laws(resolved(laws.values()), held, unused)


def lock_followers(
    compiled: Any, laws: list[Law], locked: dict[int, float]
) -> tuple[list[Law], dict[int, float]]:
    """Return the laws whose leaders move, and what is locked: also who follows a locked leader."""
    numbers = {joint_name(compiled, joint): joint for joint in range(compiled.njnt)}
    left, locked = [], dict(locked)
    for law in laws:
        leader, follower = numbers[law.leader], numbers[law.follower]
        if follower in locked:
            continue
        if leader in locked:
            locked[follower] = law.ratio * locked[leader] + law.offset
        else:
            left.append(law)
    return left, locked


def not_followed(compiled: Any, unused: list[int]) -> list[Finding]:
    """Tell of the constraints that close loops or couple otherwise: nothing here follows them."""
    found = []
    for k in unused:
        kind = EQUALITIES[int(compiled.eq_type[k])]
        name = str(compiled.equality(k).name) or f"{kind} {k}"
        found.append(
            Finding(
                WARNING,
                f"equality {name!r}",
                f"a constraint of kind {kind} is not followed: its joints count as free of it",
                "Lock its joints in the robot's YAML (locked), or leave it to the scenario",
            )
        )
    return found


def _is_affine(compiled: Any, k: int) -> bool:
    """Tell whether a constraint is a law of one joint by another, and there from the beginning."""
    if compiled.eq_type[k] != JOINT or not compiled.eq_active0[k]:
        return False
    return not np.any(compiled.eq_data[k, 2:5])


def _hangs_on(compiled: Any, joint: int, other: int) -> bool:
    """Tell whether the other joint moves a joint."""
    body, carrier = int(compiled.jnt_bodyid[joint]), int(compiled.jnt_bodyid[other])
    if body == carrier:
        return joint > other
    while body and body != carrier:
        body = int(compiled.body_parentid[body])
    return body == carrier


def _reference(compiled: Any, joint: int) -> float:
    return float(compiled.qpos0[compiled.jnt_qposadr[joint]])
