"""A scenario made for one robot, told for another: lengths scaled, places moved, links renamed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.robots import Robot, get_robot
from equipoise.robots.measures import measure
from equipoise.robots.registry import is_path
from equipoise.scenarios.schema import Scenario

Tree = dict[str, Any]


def retarget(scenario: Scenario, robot: str) -> Tree:
    """Return the keys of the scenario as they are for another robot (a name or a path).

    A point p of the world becomes c' + s (p - c): c and c' are the middles between the shoulders
    of the two robots at half-sitting, s is the ratio of their arms. All lengths scale with s,
    those of the balance with the depth of the support, those of a walk with the height of the
    centre of mass. Times, forces, masses and what the run
    must show stay; links are exchanged by the part of the body that they are.
    Raises: `ScenarioError` if something has no counterpart on the other robot.
    """
    other = get_robot(robot)
    change = _Change.between(get_robot(scenario.robot), other)
    tree = scenario.model_dump(mode="json", exclude_none=True)
    tree["robot"] = str(Path(robot).resolve()) if is_path(robot) else robot
    tree["title"] = f"{scenario.title} (made for {scenario.robot}, on {other.name})"
    _retarget_world(tree["world"], change)
    for contact in tree["contacts"].values():
        _retarget_contact(contact, change)
    for name, task in tree["tasks"].items():
        _retarget_task(task, change, f"tasks.{name}")
    if tree.get("walk") is not None:
        _retarget_walk(tree["walk"], change)
    tree["monitor"] = change.pairs(tree["monitor"], "monitor")
    for payload in tree["disturbances"]["payloads"]:
        change.scale(payload, "at")
    return tree


@dataclass(frozen=True)
class _Change:
    """How places, lengths and names change from one robot to another."""

    before: Robot
    after: Robot
    p_before: np.ndarray
    p_after: np.ndarray
    lengths: float
    stance: float
    legs: float

    @classmethod
    def between(cls, before: Robot, after: Robot) -> _Change:
        old, new = measure(before), measure(after)
        return cls(
            before,
            after,
            old.p_world_shoulders,
            new.p_world_shoulders,
            new.reach / old.reach,
            new.stance / old.stance,
            new.height / old.height,
        )

    def move(self, pose: Tree) -> None:
        """Move a pose of the world; its orientation stays."""
        p = self.p_after + self.lengths * (np.array(pose["xyz"]) - self.p_before)
        pose["xyz"] = _rounded(p)

    def scale(self, section: Tree, *keys: str) -> None:
        """Scale lengths and vectors of lengths where they are given."""
        for key in keys:
            if key in section:
                value = self.lengths * np.array(section[key])
                section[key] = _rounded(value) if value.ndim else round(float(value), 6)

    def link(self, name: str, path: str) -> tuple[str, ...]:
        """Return the links of the other robot that stand where this one does on the first."""
        in_parts = {link for links in self.before.parts.values() for link in links}
        if name not in self.before.frame_names or (
            name in self.after.frame_names and name not in in_parts
        ):
            return (name,)
        for part, links in self.before.parts.items():
            if name in links and part in self.after.parts:
                return self.after.parts[part]
        raise ScenarioError(
            f"link {name!r} of {self.before.name} has no counterpart on {self.after.name}",
            path=path,
            known=sorted(set(self.before.parts) & set(self.after.parts)),
            remedy="Name the part of the body that it is under 'parts' in the YAML of both robots",
        )

    def frame(self, section: Tree, key: str, path: str) -> None:
        """Exchange the frame that a section names."""
        if key in section:
            name = self.link(section[key], f"{path}.{key}")[0]
            if name not in self.after.frame_names:
                error = NameNotFoundError(f"frame on {self.after.name}", name, ())
                raise ScenarioError(error.problem, path=f"{path}.{key}")
            section[key] = name

    def pairs(self, pairs: Iterable[Iterable[str]], path: str) -> list[list[str]]:
        """Exchange the links of pairs of bodies; a pair that comes out twice is kept once."""
        found: dict[tuple[str, ...], None] = {}
        for i, pair in enumerate(pairs):
            links = [self.link(name, f"{path}.{i}") for name in pair]
            found.update(dict.fromkeys(product(*links)))
        return [list(pair) for pair in found if len(set(pair)) > 1]


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(x), 6) for x in values]


def _retarget_world(world: Tree, change: _Change) -> None:
    for body in world["bodies"].values():
        change.move(body["at"])
        _retarget_shapes(body, change)
    for held in world["objects"].values():
        _retarget_shapes(held, change)
        for handle in held["handles"].values():
            change.scale(handle, "xyz")
        for waypoint in held["waypoints"]:
            change.move(waypoint)
    for slider in world["sliders"].values():
        change.move(slider["at"])
        _retarget_shapes(slider, change)
        change.scale(slider, "face")
        change.scale(slider["travel"], "distance")
        slider["viscosity"] /= change.lengths  # slower by as much: the force stays


def _retarget_shapes(body: Tree, change: _Change) -> None:
    for shape in body["shapes"]:
        change.scale(shape, "box", "cylinder", "sphere")
        change.scale(shape["at"], "xyz")


def _retarget_contact(contact: Tree, change: _Change) -> None:
    change.scale(contact, "offset")
    if "surface" in contact:
        change.scale(contact["surface"], "sphere", "cylinder")
        change.move(contact["surface"]["at"])


def _retarget_walk(walk: Tree, change: _Change) -> None:
    """Scale the lengths of a walk; the soles' own margin goes with the depth of the support."""

    def scale(section: Tree | None, *keys: str) -> None:
        for key in keys:
            if section is not None and section.get(key) is not None:
                section[key] = _rounded(change.legs * np.array([section[key]]))[0]

    scale(walk, "crouch")
    scale(walk["swing"], "height")
    scale(walk.get("along"), "forward", "left")
    scale(walk.get("to"), "forward", "side")
    scale(walk["stride"], "forward", "side")
    for one in walk.get("steer") or ():
        scale(one, "forward", "left")
    if walk.get("balance") is not None:
        walk["balance"]["margin"] = round(change.stance * walk["balance"]["margin"], 6)
    walk["margin"] = round(change.stance * walk["margin"], 6)
    walk["inward"] = round(change.stance * walk["inward"], 6)


def _retarget_task(task: Tree, change: _Change, path: str) -> None:
    change.frame(task, "frame", path)
    special = _TASKS.get(task["kind"])
    if special is not None:
        special(task, change, path)


def _retarget_frame_path(task: Tree, change: _Change, path: str) -> None:
    for waypoint in task["waypoints"]:
        change.move(waypoint)


def _retarget_com_polygon(task: Tree, change: _Change, path: str) -> None:
    task["margin"] = round(change.stance * task["margin"], 6)


def _retarget_gaze(task: Tree, change: _Change, path: str) -> None:
    change.scale(task, "offset")


def _retarget_avoidance(task: Tree, change: _Change, path: str) -> None:
    change.scale(task, "influence", "security", "damping")
    task["pairs"] = change.pairs(task["pairs"], f"{path}.pairs")


def _retarget_volume(task: Tree, change: _Change, path: str) -> None:
    change.move(task["at"])
    change.scale(task, "size", "radius", "offset")


def _retarget_frame_axes(task: Tree, change: _Change, path: str) -> None:
    _retarget_frame_path(task, change, path)
    change.scale(task, "offset")


def _retarget_manipulability(task: Tree, change: _Change, path: str) -> None:
    if task["part"] != "rotation":  # three lengths
        task["least"] = task["least"] * change.lengths**3


def _retarget_relative_frame(task: Tree, change: _Change, path: str) -> None:
    change.frame(task, "relative_to", path)
    for waypoint in task["waypoints"]:
        change.scale(waypoint, "xyz")


def _retarget_joint_limits(task: Tree, change: _Change, path: str) -> None:
    for key in ("speeds", "frozen"):
        _require_joints(task.get(key, ()), change, f"{path}.{key}")


def _retarget_posture(task: Tree, change: _Change, path: str) -> None:
    _require_joints(task["joints"], change, f"{path}.joints")


def _require_joints(joints: Iterable[str], change: _Change, path: str) -> None:
    if not set(joints) <= set(change.after.joint_names):
        raise ScenarioError(
            f"not all joints named here are joints of {change.after.name}",
            path=path,
            given=sorted(joints),
            known=change.after.joint_names,
            remedy=f"Say under for_robot.{change.after.name} where its joints should be",
        )


# What else than frames changes, by kind of task
_TASKS: dict[str, Callable[[Tree, _Change, str], None]] = {
    "frame_path": _retarget_frame_path,
    "frame_way": _retarget_frame_path,
    "com_polygon": _retarget_com_polygon,
    "gaze": _retarget_gaze,
    "avoidance": _retarget_avoidance,
    "posture": _retarget_posture,
    "joint_limits": _retarget_joint_limits,
    "joint_coupling": _retarget_posture,
    "frame_axes": _retarget_frame_axes,
    "relative_frame": _retarget_relative_frame,
    "manipulability": _retarget_manipulability,
    "com_point": _retarget_frame_path,
    "keep_in": _retarget_volume,
    "keep_out": _retarget_volume,
}
