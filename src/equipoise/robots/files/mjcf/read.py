"""From an MJCF to what a robot is made of: models, postures, and what was found on the way."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.errors import NameNotFoundError, RobotFileError, quoted
from equipoise.robots.base import BASES, FIXED, FLOATING
from equipoise.robots.files.build import neighbouring_links
from equipoise.robots.files.described import Described
from equipoise.robots.files.extras_schema import Extras
from equipoise.robots.files.finding import WARNING, Finding
from equipoise.robots.files.mjcf.agreement import require_agreement
from equipoise.robots.files.mjcf.compiled import (
    FREE,
    HINGE,
    body_name,
    compile_mjcf,
    joint_name,
)
from equipoise.robots.files.mjcf.laws import lock_followers, not_followed, read_laws
from equipoise.robots.files.mjcf.limits import limits_of
from equipoise.robots.files.mjcf.shapes import build_shapes, excluded
from equipoise.robots.files.mjcf.text import read_mjcf
from equipoise.robots.files.mjcf.tree import Tree, base_in_file, build_tree
from equipoise.robots.files.values import LIMIT_SLACK

STARTS = ("half_sitting", "stand", "home")  # keyframes to begin with; else the first one
NOT_HERE = ("inertials", "shapes", "cylinders_are_capsules")


def describe_mjcf(path: Path, extras: Extras, base: str | None) -> Described:
    """Return the robot of an MJCF, of which MuJoCo and Pinocchio agree what it is.

    Raises: RobotFileError, NameNotFoundError.
    """
    for key in NOT_HERE:
        if getattr(extras, key):
            raise RobotFileError(
                f"The YAML of {path} has the key {key!r}, which is for URDFs",
                remedy="Correct the MJCF itself",
            )
    compiled = compile_mjcf(read_mjcf(path), path)
    in_file, root = base_in_file(compiled, path)
    findings = _without_armature_of_base(compiled)
    found = read_laws(compiled, set(_locked(compiled, extras)))
    limits, told = limits_of(compiled, extras.limits, {law.follower for law in found.laws})
    require_agreement(compiled, build_tree(compiled, in_file, root, limits, {}), path)
    wanted = BASES[base] if base is not None else in_file
    if wanted is FLOATING and in_file is FIXED:
        root = _only_tree(compiled, path)
    locked = _locked(compiled, extras)
    laws, locked = lock_followers(compiled, found.laws, {**found.held, **locked})
    tree = build_tree(compiled, wanted, 0 if wanted is FIXED else root, limits, locked)
    collision, visual = build_shapes(compiled, tree)
    _add_frames(tree, extras)
    postures = keyframes(compiled, tree)
    start = next((name for name in (*STARTS, *postures) if name in postures), None)
    disabled = neighbouring_links(tree.model, collision) | excluded(compiled)
    findings += [*told, *not_followed(compiled, found.unused), *tree.findings]
    name = compiled.names[: compiled.names.index(b"\0")].decode("utf-8", "replace")
    return Described(
        name, tree.model, collision, visual, wanted, disabled, postures, start, findings,
        laws=laws,
    )  # fmt: skip


def keyframes(compiled: Any, tree: Tree) -> dict[str, dict[str, float]]:
    """Return the keyframes as postures within the limits: name -> joint -> coordinate.

    What a keyframe puts outside of a limit is moved to it, and told.
    """
    found: dict[str, dict[str, float]] = {}
    low, high = tree.model.lowerPositionLimit, tree.model.upperPositionLimit
    for key in range(compiled.nkey):
        name = str(compiled.key(key).name) or f"key_{key}"
        posture, moved = found.setdefault(name, {}), []
        for theirs, ours in tree.joint.items():
            at, joint = tree.model.joints[ours].idx_q, joint_name(compiled, theirs)
            q = float(compiled.key_qpos[key, compiled.jnt_qposadr[theirs]])
            posture[joint] = float(np.clip(q, low[at], high[at]))
            moved += [joint] if abs(posture[joint] - q) > LIMIT_SLACK else []
        if moved:
            problem = "it is moved into its limits in this posture"
            tree.findings.append(Finding(WARNING, f"key {name!r}, joint {moved[0]}", problem))
    return found


def _without_armature_of_base(compiled: Any) -> list[Finding]:
    """Take out the armature of a free joint: no rotor turns there, a default class wrote it."""
    for joint in np.flatnonzero(np.array(compiled.jnt_type) == FREE):
        dof = int(compiled.jnt_dofadr[joint])
        if np.any(compiled.dof_armature[dof : dof + 6]):
            compiled.dof_armature[dof : dof + 6] = 0.0
            place = f"body {body_name(compiled, int(compiled.jnt_bodyid[joint]))!r}"
            problem = "its free joint has an armature, which no rotor stands for: it is left out"
            return [Finding(WARNING, place, problem, "Write <freejoint/>, which takes no defaults")]
    return []


def _only_tree(compiled: Any, path: Path) -> int:
    """Return the body of the world from which all others hang. Raises: RobotFileError."""
    roots = [body for body in range(1, compiled.nbody) if compiled.body_parentid[body] == 0]
    if len(roots) != 1:
        raise RobotFileError(
            f"{path} has {len(roots)} bodies on the world; one could float",
            given=", ".join(body_name(compiled, root) for root in roots),
            remedy="Say base: fixed, or hang them on one body",
        )
    return roots[0]


def _locked(compiled: Any, extras: Extras) -> dict[int, float]:
    """Return by joint where it is locked. Raises: NameNotFoundError, RobotFileError."""
    names = {
        joint_name(compiled, joint): joint
        for joint in range(compiled.njnt)
        if compiled.jnt_type[joint] != FREE
    }
    found = {}
    for pattern, value in extras.locked.items():
        matching = [name for name in names if fnmatchcase(name, pattern)]
        if not matching:
            raise NameNotFoundError(
                "joint (named by the key 'locked' of the robot's YAML)", pattern, names
            )
        for name in matching:
            joint = names[name]
            low, high = compiled.jnt_range[joint]
            limited = bool(compiled.jnt_limited[joint])
            if limited and not low - LIMIT_SLACK <= value <= high + LIMIT_SLACK:
                if name == pattern:
                    unit = "rad" if compiled.jnt_type[joint] == HINGE else "m"
                    raise RobotFileError(
                        f"joint {quoted(name)} cannot be locked there: its range is {low:g} to "
                        f"{high:g} {unit}",
                        given=value,
                        remedy="Lock it inside its range",
                    )
                value = float(np.clip(value, low, high))
            found[joint] = value
    return found


def _add_frames(tree: Tree, extras: Extras) -> None:
    """Add the frames of the YAML, and those of the palms' skins."""
    model = tree.model
    known = {frame.name: k for k, frame in enumerate(model.frames)}
    added = [(f.name, f.on, f.xyz, f.rpy) for f in extras.frames]
    for palm in extras.palms:
        if palm.skin > 0.0:
            skin = (0.0, 0.0, palm.skin)
            added.append((f"{palm.name}_skin", palm.frame, skin, (0.0, 0.0, 0.0)))
    for name, on, xyz, rpy in added:
        if on not in known:
            raise NameNotFoundError(f"frame (named by the key 'frames', {name})", on, known)
        above = model.frames[known[on]]
        T = above.placement * pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))
        frame = pin.Frame(name, above.parentJoint, known[on], T, pin.FrameType.OP_FRAME)
        known[name] = model.addFrame(frame, False)
