"""Why a handle is short of where it was dragged: sentences, and the joints that are in the way."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from equipoise.hqp import Hierarchy
from equipoise.hqp.explain import explain
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import Task, describe_rows

NAMED = 2  # bounds that a sentence names
# rows that only stand in the way where no speed of the joints would bring the hand on
STRETCHED = ("the rest of", "the acceleration limit of", "the speed limit of")


@dataclass(frozen=True)
class Reason:
    """Why handles are short: sentences, and the joints of the model whose limits are in the way."""

    sentences: tuple[str, ...] = ()
    joints: tuple[int, ...] = ()


@dataclass(frozen=True)
class Solved:
    """A hierarchy with its tasks, in their levels, and its answer `v` (nv,)."""

    levels: Sequence[Sequence[Task]]
    hierarchy: Hierarchy
    v: Array


def find_reason(robot: Robot, solved: Solved, off: Mapping[str, float]) -> Reason:
    """Say what stands in the way of tasks; `off` gives by task how short [m] its handle is."""
    tasks = [task for level in solved.levels for task in level]
    words = describe_rows(tasks, solved.hierarchy)
    said = explain(solved.hierarchy, solved.v, words, tasks=list(off))
    names, joints, sentences = list(robot.model.names), [], []
    for one in said.shortfalls:
        told = [b for b in one.breaking if not b.phrase.startswith(STRETCHED)][:NAMED]
        by = " and ".join(dict.fromkeys(re.sub(r"edge\d+", "edge", b.phrase) for b in told))
        why = f"stopped by {by}" if by else "it is stretched out and reaches no further"
        sentences.append(f"{one.task} is {100 * off[one.task]:.0f} cm short: {why}.")
        for blocker in one.breaking[:NAMED]:
            label = blocker.name.split("/", 1)[-1]
            if label in names:
                joints.append(names.index(label))
    return Reason(tuple(sentences), tuple(dict.fromkeys(joints)))


def joined(reasons: Sequence[Reason]) -> Reason:
    """Return several reasons as one, each joint once."""
    joints = dict.fromkeys(joint for one in reasons for joint in one.joints)
    return Reason(tuple(s for one in reasons for s in one.sentences), tuple(joints))
