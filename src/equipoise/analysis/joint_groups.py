"""Which joints belong together in a figure: legs, arms, torso and head."""

from __future__ import annotations

import re
from dataclasses import dataclass

from equipoise.robots import Robot

_MOST_JOINTS = 8


@dataclass(frozen=True)
class JointGroup:
    """Joints of one limb: its title, and their places among the actuated joints, from the base."""

    title: str
    joints: tuple[int, ...]

    def short_names(self, names: tuple[str, ...]) -> list[str]:
        """Return the joints' names without what all of them share."""
        mine = [names[i] for i in self.joints]
        cut = 0
        if len(mine) > 1:
            first, last = min(mine), max(mine)
            alike = [a == b for a, b in zip(first, last, strict=False)]
            shared = first[: [*alike, False].index(False)]
            cut = shared.rfind("_") + 1
        return [name[cut:] for name in mine]


def joint_groups_of(robot: Robot | None, names: tuple[str, ...]) -> list[JointGroup]:
    """Return the groups that the actuated joints `names` make up, legs first.

    With a robot, a limb is the path from the trunk to a sole or a palm, with the fingers beyond;
    the trunk and what else is left (neck, head) is one more. Without, joints whose names begin
    alike are a group. A limb of many joints is cut into several.
    """
    if robot is None or robot.joint_names != names:
        return _cut(_by_beginning(names))
    return _cut(_by_tree(robot))


def _by_tree(robot: Robot) -> list[JointGroup]:
    ends = [(sole.frame, "leg") for sole in robot.soles]
    ends += [(palm.frame, "arm") for palm in robot.palms]
    paths = {frame: _path(robot, frame) for frame, _ in ends}
    owner: dict[int, str] = {}
    for frame, path in paths.items():
        others = {joint for other, taken in paths.items() if other != frame for joint in taken}
        owner.update((joint, frame) for joint in path if joint not in others)
    for joint in range(robot.base.first_joint, robot.model.njoints):
        parent = robot.model.parents[joint]
        if joint not in owner and parent in owner:
            owner[joint] = owner[parent]
    place = {joint: k for k, joint in enumerate(robot.actuated)}
    joint_groups = [
        JointGroup(_title(frame, kind), tuple(k for j, k in place.items() if owner.get(j) == frame))
        for frame, kind in ends
    ]
    rest = tuple(k for j, k in place.items() if j not in owner)
    if rest:
        legs = sum(kind == "leg" for _, kind in ends)
        joint_groups.insert(legs, JointGroup("Torso and head" if ends else "Joints", rest))
    return [group for group in joint_groups if group.joints]


def _path(robot: Robot, frame: str) -> set[int]:
    """Return the actuated joints between the base and a frame."""
    joint = robot.model.frames[robot.frame_id(frame)].parentJoint
    path = set()
    while joint >= robot.base.first_joint:
        path.add(joint)
        joint = robot.model.parents[joint]
    return path


def _title(frame: str, kind: str) -> str:
    for side in ("left", "right"):
        if side in frame.lower():
            return f"{side.capitalize()} {kind}"
    return f"{kind.capitalize()} to {frame}"


def _by_beginning(names: tuple[str, ...]) -> list[JointGroup]:
    groups: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        beginning = re.split(r"[^A-Za-z]", name, maxsplit=1)[0]
        groups.setdefault(beginning or "Joints", []).append(i)
    return [JointGroup(title, tuple(joints)) for title, joints in groups.items()]


def _cut(joint_groups: list[JointGroup]) -> list[JointGroup]:
    pieces = []
    for group in joint_groups:
        count = -(-len(group.joints) // _MOST_JOINTS)
        size = -(-len(group.joints) // count)
        for k in range(count):
            title = group.title if count == 1 else f"{group.title}, {k + 1} of {count}"
            pieces.append(JointGroup(title, group.joints[k * size : (k + 1) * size]))
    return pieces
