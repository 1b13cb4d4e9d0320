"""Guesses what a description does not say: who stands, who holds, how it sits. A YAML to correct.

What is found is a beginning: names and geometry of others follow habits, not rules.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

from equipoise.robots.load import load_robot
from equipoise.robots.robot import Robot

FOOT = ("sole", "foot", "ankle", "toe", "calf", "shank", "wrist_roll_leg")
HAND = ("tcp", "tool0", "tool", "ee_link", "palm", "gripper", "hand", "wrist")
HEAD = ("head", "neck", "camera")
FINGER = ("finger", "thumb", "knuckle", "gripper", "hand_")
WHEEL = ("wheel", "caster", "castor")
POSTURES = ("half_sitting", "standing", "stand", "home")  # by habit
FLAT = 0.03  # [m] a sole is at least this long and wide
LOW = 0.02  # [m] above the lowest point that a shape may touch the ground
BENT = 0.7  # [rad] of a knee, half of it at hip and ankle


def guess_yaml(path: str | Path) -> str:
    """Return a YAML for a URDF or MJCF: what it is, who stands, who holds, each with its reason.

    Raises: RobotFileError as `load_robot` does.
    """
    robot = load_robot(path, base=None)
    ends = _ends(robot)
    legs, arms = _sorted_ends(robot, ends)
    lines = [
        f"# Guessed from {Path(path).name}: correct what is wrong, then equipoise check this file.",
        f"name: {robot.name}",
        f"{'mjcf' if Path(path).suffix == '.xml' else 'urdf'}: {Path(path).name}",
    ]
    floats = bool(robot.nv_base) and bool(legs)
    lines.append(f"base: {_base(robot, legs)}")
    if floats:
        lines += _standing(robot, legs)
    lines += _palms(robot, arms)
    lines += _locked(robot)
    lines += _half_sitting(robot, legs if floats else [])
    return "\n".join(lines) + "\n"


def ends_of_arms(robot: Robot) -> tuple[str, ...]:
    """Return a frame at the end of each limb that is no leg, the one that is named like a hand."""
    _, arms = _sorted_ends(robot, _ends(robot))
    return tuple(_frame_at(robot, joint, HAND) for joint in arms)


def _base(robot: Robot, legs: list[int]) -> str:
    """Return the kind of base with the reason."""
    if not robot.nv_base:
        return "fixed  # as the file says"
    if legs:
        return f"floating  # {len(legs)} legs were found"
    wheels = _named(robot, WHEEL)
    if wheels:
        return f"planar  # {len(wheels)} wheels were found: taken to drive in any direction"
    return "fixed  # no legs were found"


def _named(robot: Robot, words: Iterable[str]) -> list[str]:
    """Return the joints whose name has one of the words."""
    return [name for name in robot.joint_names if any(word in name.lower() for word in words)]


def _ends(robot: Robot) -> list[int]:
    """Return the joints that carry no other, but fingers and wheels: each is the end of a limb."""
    model = robot.model
    names = {j: str(model.names[j]).lower() for j in range(robot.base.first_joint, model.njoints)}
    limbs = [j for j, name in names.items() if not any(word in name for word in FINGER + WHEEL)]
    parents = {model.parents[j] for j in limbs}
    return [j for j in limbs if j not in parents]


def _sorted_ends(robot: Robot, ends: list[int]) -> tuple[list[int], list[int]]:
    """Return the ends of legs, the lowest at zero joints, and of arms."""
    names = {j: " ".join(_names_at(robot, j)).lower() for j in ends}
    legs = [j for j in ends if any(word in names[j] for word in FOOT)]
    legs = legs if len(legs) > 1 else []
    others = [j for j in ends if j not in legs]
    return legs, [j for j in others if not any(word in names[j] for word in HEAD)] or others


def _names_at(robot: Robot, joint: int) -> list[str]:
    """Return the names of the frames on a joint, and the joint's own."""
    frames = [f.name for f in robot.model.frames if f.parentJoint == joint]
    return [str(robot.model.names[joint]), *frames]


def _frame_at(robot: Robot, joint: int, words: Iterable[str]) -> str:
    """Return the frame on a joint whose name says most, else the link that moves with it."""
    frames = [
        f.name
        for f in robot.model.frames
        if f.parentJoint == joint and f.type in (pin.FrameType.BODY, pin.FrameType.OP_FRAME)
    ]
    for word in words:
        found = [name for name in frames if word in name.lower()]
        if found:
            return found[-1]
    return frames[0]


def _standing(robot: Robot, legs: list[int]) -> list[str]:
    """Return soles where the foot is a flat area, feet where it is a point."""
    q = robot.q_half_sitting
    soles, feet = [], []
    for joint in legs:
        frame = _frame_at(robot, joint, FOOT)
        T = robot.at(q).placement(frame)
        below = _lowest(robot, joint, frame)
        name = str(robot.model.names[joint]).removesuffix("_joint")
        if below is None:
            feet.append(f"  - {{name: {name}, frame: {frame}}}  # no shape tells how far below")
            continue
        floor = pin.SE3(np.eye(3), np.array([*T.translation[:2], below[:, 2].min()]))
        x0, y0, x1, y1 = _sides(below - floor.translation)
        if len(legs) == 2 and x1 - x0 > FLAT and y1 - y0 > FLAT:
            size = f"x_min: {x0:.3f}, x_max: {x1:.3f}, y_min: {y0:.3f}, y_max: {y1:.3f}"
            place = T.actInv(floor)
            xyz = ", ".join(f"{x:.4f}" for x in place.translation)
            rpy = ", ".join(f"{x:.6f}" for x in pin.rpy.matrixToRpy(place.rotation))
            low = f"{{name: {name}_sole, on: {frame}, xyz: [{xyz}], rpy: [{rpy}]}}"
            soles.append((low, f"  - {{name: {name}, frame: {name}_sole, {size}}}"))
        else:
            radius = max(float(T.translation[2] - floor.translation[2]), 0.0)
            feet.append(f"  - {{name: {name}, frame: {frame}, radius: {radius:.3f}}}")
    lines = []
    if soles:
        lines += ["frames:", *(f"  - {low}" for low, _ in soles)]
        lines += ["soles:  # what the shapes of the feet cover on the ground"]
        lines += [sole for _, sole in soles]
    return [*lines, *(["feet:", *feet] if feet else [])]


def _sides(points: np.ndarray) -> tuple[float, float, float, float]:
    """Return least x and y, and largest, of points (k, 3)."""
    (x0, y0), (x1, y1) = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    return float(x0), float(y0), float(x1), float(y1)


def _lowest(robot: Robot, joint: int, frame: str) -> np.ndarray | None:
    """Return the corners (k, 3) of a foot's shapes that are near its lowest point, world axes.

    The shapes of the frame itself count, and those of all that its joint moves if it has none.
    """
    T, points = robot.at(robot.q_half_sitting).joint_placement(joint), []
    shapes = [s for s in robot.collision_model.geometryObjects if s.parentJoint == joint]
    own = [s for s in shapes if s.parentFrame == robot.frame_id(frame)]
    for shape in own or shapes:
        box = shape.geometry
        box.computeLocalAABB()
        low, high = box.aabb_local.min_, box.aabb_local.max_
        corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
        placed = T * shape.placement
        if isinstance(box, coal.Sphere):  # its corners are off: the ends of its axes
            corners = box.radius * np.vstack([np.eye(3), -np.eye(3)])
            placed = pin.SE3(np.eye(3), placed.translation)
        elif isinstance(box, coal.ConvexBase):
            corners = np.array(box.points())
        points.append(corners @ placed.rotation.T + placed.translation)
    if not points:
        return None
    corners = np.vstack(points)
    return corners[corners[:, 2] < corners[:, 2].min() + LOW]


def _palms(robot: Robot, arms: list[int]) -> list[str]:
    if not arms:
        return []
    lines = ["palms:  # x should point along the fingers, z out of the palm"]
    for joint in arms:
        name = str(robot.model.names[joint]).removesuffix("_joint")
        lines.append(f"  - {{name: {name}_hand, frame: {_frame_at(robot, joint, HAND)}}}")
    return lines


def _locked(robot: Robot) -> list[str]:
    fingers, wheels = _named(robot, FINGER), _named(robot, WHEEL)
    if not fingers and not wheels:
        return []
    lines = ["locked:  # fingers and wheels: joints that no task here needs"]
    for name in [*fingers, *wheels]:
        k = robot.joint_index(name)
        lines.append(f"  {name}: {float(np.clip(0.0, robot.q_min[k], robot.q_max[k])):.4g}")
    return lines


def _half_sitting(robot: Robot, legs: list[int]) -> list[str]:
    """Return the posture of the file, or one with bent knees: the longest bend of each leg."""
    base = robot.nq_base
    q = robot.q_half_sitting[base:].copy()
    known = next((robot.postures[name] for name in POSTURES if name in robot.postures), None)
    if known is not None:
        q = np.array([known.get(name, q[k]) for k, name in enumerate(robot.joint_names)])
    else:
        for joint in legs:
            for k, angle in _bend(robot, joint).items():
                q[k] = np.clip(angle, robot.q_min[k], robot.q_max[k])
    told = {name: q[k] for k, name in enumerate(robot.joint_names) if abs(q[k]) > 1e-9}
    if not told:
        return ["half_sitting: {}  # all joints at zero, or at the limit next to it"]
    return ["half_sitting:", *(f"  {name}: {angle:.4g}" for name, angle in told.items())]


def _bend(robot: Robot, joint: int) -> dict[int, float]:
    """Return by joint of a leg its bend: hip, knee and ankle turn about the lateral axis."""
    model, kin = robot.model, robot.at(robot.q_half_sitting)
    pitching = []
    for one in list(model.supports[joint])[robot.base.first_joint :]:
        k = model.joints[one].idx_v
        column = kin.jacobian(_frame_at(robot, one, ()))[:, k]
        if abs(column[4]) > 0.8:  # about y
            pitching.append((k - robot.nv_base, float(np.sign(column[4])), one))
    heights = [kin.joint_placement(one).translation[2] for _, _, one in pitching]
    if len(pitching) < 2 or not all(a > b for a, b in pairwise(heights)):
        return {}
    share = (-0.5, 1.0, -0.5) if len(pitching) > 2 else (0.5, -1.0)
    return {k: sign * BENT * part for (k, sign, _), part in zip(pitching, share, strict=False)}
