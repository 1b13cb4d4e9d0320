"""Levels of tasks as most robots want them: contacts, then limits and balance, wishes, posture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from equipoise.contacts import Contact, ContactStack, PointContact, SoleContact, SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.errors import InputError, NameNotFoundError
from equipoise.given import names_of
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_number, real_vector
from equipoise.tasks import (
    ComPolygonTask,
    ContactTask,
    JointAccelerationsTask,
    JointLimitsTask,
    PostureTask,
    Task,
)

Wishes = Sequence[Task | Sequence[Task]]
Accelerations = float | Array | Mapping[str, float]


def feet_of(
    robot: Robot, q: Array, names: Sequence[str] | None, friction: float
) -> list[SoleContact | PointContact]:
    """Return what stands on the ground at `q` (nq,): soles, or points where a frame is named.

    `names` are soles or frames; None means every sole of the robot, and nothing on a fixed base.
    Raises: `InputError`, `NameNotFoundError`.
    """
    kin = robot.at(q)
    soles = {sole.name: sole for sole in robot.soles}
    if names is None:
        if robot.nv_base and not soles:
            raise InputError(
                f"robot {robot.name} has no soles, so nothing says where it stands",
                known=robot.frame_names,
                remedy='Name the frames of its feet, feet=("left_toe", ...), or soles in its YAML',
            )
        names = tuple(soles) if robot.nv_base else ()
    names = names_of("the feet", names)
    for name in names:
        if name not in soles and name not in robot.frame_names:
            known = (*soles, *robot.frame_names)
            raise NameNotFoundError(f"sole or frame on robot {robot.name}:", name, known)
    return [
        SoleContact.standing(soles[name], kin, friction=friction)
        if name in soles
        else PointContact.standing(name, kin, friction=friction)
        for name in names
    ]


def polygon_of(feet: Sequence[Contact]) -> SupportPolygon:
    """Return the polygon around soles and points. Raises: `InputError` if they span no area."""
    points = [np.zeros((0, 3))]
    for foot in feet:
        if isinstance(foot, SoleContact):
            points.append(sole_corners(foot.sole, foot.T_world_anchor))
        elif isinstance(foot, PointContact):
            points.append(np.asarray(foot.p_world, dtype=float)[None])
    return SupportPolygon.of_points(np.vstack(points))


def ground_of(feet: Sequence[Contact]) -> float:
    """Return the height [m] of the lowest sole or point that stands, 0 if there is none."""
    heights: list[float] = []
    for foot in feet:
        if isinstance(foot, SoleContact):
            heights.append(float(foot.T_world_anchor.translation[2]))
        elif isinstance(foot, PointContact):
            heights.append(float(foot.p_world[2]))
    return min(heights, default=0.0)


def usual_levels(
    robot: Robot, q: Array, contacts: Sequence[Contact], wishes: Wishes, margin: float
) -> list[list[Task]]:
    """Return contacts; joint limits and balance; the wishes, a level each; the posture `q` (nq,).

    Balance keeps the centre of mass `margin` [m] inside the polygon of the supporting contacts,
    leaning into what hands press.
    What the wishes hold of posture, limits or balance, by kind, is theirs and not added.
    Raises: `InputError`.
    """
    if not isinstance(wishes, Sequence) or isinstance(wishes, str):
        raise _no_level(wishes)
    given = [_level(wish) for wish in wishes]
    has = {type(task) for level in given for task in level}
    supports = [contact for contact in contacts if contact.supporting]
    keep: list[Task] = []
    if JointLimitsTask not in has:
        keep.append(JointLimitsTask("limits", robot, rate=5.0))
    if supports and ComPolygonTask not in has:
        ground = ground_of(supports)
        keep.append(
            ComPolygonTask(
                "balance", polygon_of(supports), margin=margin, leans=True, height=ground
            )
        )
    levels: list[list[Task]] = []
    if contacts:
        levels.append([ContactTask("contacts", ContactStack(contacts))])
    levels += [keep] if keep else []
    levels += given
    if PostureTask not in has:
        levels.append([PostureTask("posture", robot, q[robot.nq_base :])])
    return levels


def bound_accelerations(
    robot: Robot, levels: Sequence[Sequence[Task]], accelerations: Accelerations, period: float
) -> list[list[Task]]:
    """Return the levels with bounds on joint accelerations [rad/s^2], right below the contacts.

    One number for all joints, one for each (na,), or some by name: the others may turn round at
    full speed in one period [s]. Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
    """
    what, most = "the joint accelerations", 2.0 * robot.v_max / period
    if isinstance(accelerations, Mapping):
        for name, value in accelerations.items():
            if name not in robot.joint_names:
                raise NameNotFoundError("joint", name, robot.joint_names)
            most[robot.joint_names.index(name)] = real_number(f"{what} of {name}", value)
    elif np.ndim(accelerations):
        most = real_vector(what, accelerations, robot.na)
    else:
        most = np.full(robot.na, real_number(what, accelerations))
    below = int(bool(levels) and any(isinstance(task, ContactTask) for task in levels[0]))
    bounds: list[Task] = [JointAccelerationsTask("accelerations", robot, most, period)]
    return [*map(list, levels[:below]), bounds, *map(list, levels[below:])]


def _level(wish: Task | Sequence[Task]) -> list[Task]:
    level = [wish] if isinstance(wish, Task) else wish
    if isinstance(level, str) or not isinstance(level, Sequence):
        raise _no_level(wish)
    if not all(isinstance(task, Task) for task in level):
        raise _no_level(wish)
    return list(level)


def _no_level(given: object) -> InputError:
    return InputError(
        "a level is a task, or a list of tasks that share it",
        given=type(given).__name__,
        remedy="Give [first, [second, third], ...], highest priority first",
    )
