"""What a person calls the rows of each kind of task, with unit and rate: words for explanations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.hqp.row_names import plain_descriptions
from equipoise.tasks.avoidance import AvoidanceTask
from equipoise.tasks.base import Task
from equipoise.tasks.com_polygon import ComPolygonTask
from equipoise.tasks.contact_rows import ContactTask
from equipoise.tasks.frame_pose import FramePoseTask
from equipoise.tasks.gaze import GazeTask
from equipoise.tasks.joint_limits import JointLimitsTask
from equipoise.tasks.posture import PostureTask

Words = tuple[RowDescription, ...]


def describe_rows(tasks: Iterable[Task], hierarchy: Hierarchy) -> Words:
    """Return the words of every row [m] of a hierarchy that these tasks were asked for.

    Rows of a task of one's own keep the names they have in the hierarchy.
    """
    makers = {task.name: partial(_words_of(task), task) for task in tasks if _words_of(task)}
    words = list(plain_descriptions(hierarchy))
    for block in hierarchy.blocks:
        if block.name in makers:
            words[block.rows] = makers[block.name](block, hierarchy)
    return tuple(words)


def _words_of(task: Task) -> Callable[..., Words] | None:
    return next((made for kind, made in _WORDS.items() if isinstance(task, kind)), None)


def _by_component(task: Task, block: Block, hierarchy: Hierarchy) -> Words:
    rate = task.rate
    units = dict(zip(task.labels, task.units, strict=True))
    return tuple(
        RowDescription.both(task.name, f"{units[label]}/s", rate) for label in block.labels
    )


def _posture(task: PostureTask, block: Block, hierarchy: Hierarchy) -> Words:
    return tuple(
        RowDescription.both(f"the posture of {label}", "rad/s", task.rate) for label in block.labels
    )


def _contacts(task: ContactTask, block: Block, hierarchy: Hierarchy) -> Words:
    units = dict(zip(task.labels, task.units, strict=True))
    return tuple(
        RowDescription.both(f"the contact {label.split('/')[0]}", f"{units[label]}/s", task.rate)
        for label in block.labels
    )


def _edges(task: ComPolygonTask, block: Block, hierarchy: Hierarchy) -> Words:
    return tuple(
        RowDescription.both(f"the {label} of the support polygon", "m/s", task.rate)
        for label in block.labels
    )


def _limits(task: JointLimitsTask, block: Block, hierarchy: Hierarchy) -> Words:
    words = []
    ends = (hierarchy.upper[block.rows], hierarchy.lower[block.rows])
    for joint, upper, lower, speed in zip(block.labels, *ends, task.v_share, strict=True):
        above, rate_above = _limit(f"the upper limit of {joint}", joint, upper, speed, task.rate)
        below, rate_below = _limit(f"the lower limit of {joint}", joint, lower, speed, task.rate)
        words.append(RowDescription("rad/s", above, below, rate_above, rate_below))
    return tuple(words)


def _limit(phrase: str, joint: str, bound: float, speed: float, rate: float) -> tuple[str, float]:
    """Return the words of a bound: a limit of position, or of speed where that is the closer."""
    if np.abs(bound) >= speed:
        return f"the speed limit of {joint}", math.nan
    return phrase, rate


def _distances(task: AvoidanceTask, block: Block, hierarchy: Hierarchy) -> Words:
    rate = task.damping / (task.influence - task.security)
    return tuple(  # the rows of a capsule's ends are named "first - second (end, other)"
        RowDescription.both(f"the distance {label.split(' (')[0]}", "m/s", rate)
        for label in block.labels
    )


_WORDS: dict[type, Callable[..., Words]] = {
    FramePoseTask: _by_component,
    GazeTask: _by_component,
    PostureTask: _posture,
    ContactTask: _contacts,
    ComPolygonTask: _edges,
    JointLimitsTask: _limits,
    AvoidanceTask: _distances,
}
