"""Loads a robot: check the text, build with Pinocchio, check the model, wrap it frozen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin

from equipoise.errors import NameNotFoundError, quoted
from equipoise.robots.base import FLOATING, Base, base_of, require_joints_of_one_dof
from equipoise.robots.files.base import take_base
from equipoise.robots.files.build import (
    add_collision_pairs,
    build_geometry,
    build_model,
    neighbouring_links,
    take_hulls,
)
from equipoise.robots.files.check_model import check_model
from equipoise.robots.files.check_tree import check_tree
from equipoise.robots.files.description import Node
from equipoise.robots.files.extras_schema import Extras
from equipoise.robots.files.finding import WARNING, Finding, raise_errors, tell_warnings
from equipoise.robots.files.source import Source, find_source
from equipoise.robots.files.srdf import Semantics, read_srdf
from equipoise.robots.robot import (
    Palm,
    Robot,
    Sole,
)

HALF_SITTING = "half_sitting"


def load_robot(
    urdf_path: str | Path,
    *,
    srdf_path: str | Path | None = None,
    extras_path: str | Path | None = None,
    package_dirs: Sequence[str | Path] = (),
    base: str | None = None,
) -> Robot:
    """Load a robot from its URDF, its YAML or the folder of either.

    `base` is "floating" or "fixed"; without it the YAML decides, and else the URDF: a first link
    called `world` is fixed, any other floats.

    The SRDF (postures, pairs of links that need no collision check) and the YAML (soles, palms,
    camera, and what the URDF lacks) are taken from files of the same stem beside the URDF when
    they are not given; both may be missing. A YAML may name its URDF elsewhere. `package_dirs`
    are folders that hold the packages of package:// paths.

    What `check_urdf` warns of is said here too, by the log `equipoise.robots`.
    Raises: RobotFileError, NameNotFoundError.
    """
    robot, findings = load_and_check(
        urdf_path,
        srdf_path=srdf_path,
        extras_path=extras_path,
        package_dirs=package_dirs,
        base=base,
    )
    tell_warnings(Path(urdf_path), findings)
    return robot


def load_and_check(
    urdf_path: str | Path,
    *,
    srdf_path: str | Path | None = None,
    extras_path: str | Path | None = None,
    package_dirs: Sequence[str | Path] = (),
    base: str | None = None,
) -> tuple[Robot, list[Finding]]:
    """Return what `load_robot` returns, and the warnings.

    Raises: RobotFileError, NameNotFoundError.
    """
    source = find_source(urdf_path, srdf_path=srdf_path, extras_path=extras_path)
    urdf = source.urdf
    tree, kind = take_base(source.tree(), base or source.extras.base)
    checked, findings = check_tree(tree, urdf, package_dirs, kind)
    raise_errors(urdf, findings)
    robot = _built(source, kind, checked, findings)
    return robot, findings


def _built(source: Source, base: Base, checked: Node, findings: list[Finding]) -> Robot:
    """Return the robot of a checked tree; add what is found while it is built.

    Raises: RobotFileError, NameNotFoundError.
    """
    urdf, extras = source.urdf, source.extras
    semantics = read_srdf(source.srdf) if source.srdf else None

    model = build_model(checked, base)
    require_joints_of_one_dof(model)
    capsules = extras.has_capsules
    collision = build_geometry(checked, model, pin.GeometryType.COLLISION, as_capsules=capsules)
    findings += take_hulls(model, collision)
    visual = build_geometry(checked, model, pin.GeometryType.VISUAL, as_capsules=capsules)
    disabled = semantics.disabled_pairs if semantics else neighbouring_links(model, collision)
    add_collision_pairs(model, collision, disabled)
    soles = tuple(Sole(**entry.model_dump()) for entry in extras.soles)
    q = half_sitting_configuration(model, _posture(extras, semantics), soles)
    raise_errors(urdf, check_model(model, q))
    findings += unknown_links(source.srdf, semantics, model)
    if not soles and base is FLOATING:
        remedy = f"List the soles in {source.yaml.name}, or say base: fixed there"
        findings.append(Finding(WARNING, "robot", "no soles: it cannot stand", remedy=remedy))
    return Robot(
        name=extras.name or checked.get("name") or urdf.stem,
        model=model,
        collision_model=collision,
        visual_model=visual,
        urdf_path=urdf.resolve(),
        soles=soles,
        palms=tuple(Palm(**entry.model_dump()) for entry in extras.palms),
        camera=extras.camera,
        q_half_sitting=q,
        parts=extras.links_of_parts,
    )


def unknown_links(
    srdf: Path | None, semantics: Semantics | None, model: pin.Model
) -> list[Finding]:
    """Warn of disabled collision pairs with a link that does not exist: they disable nothing."""
    if srdf is None or semantics is None:
        return []
    known = {frame.name for frame in model.frames}
    unknown = sorted({link for pair in semantics.disabled_pairs for link in pair} - known)
    return [
        Finding(WARNING, f"{srdf.name}, link {quoted(link)}", "no such link", "Correct its name")
        for link in unknown
    ]


def half_sitting_configuration(
    model: pin.Model, posture: dict[str, float], soles: tuple[Sole, ...]
) -> np.ndarray:
    """Return q (nq,): upright base, the soles' lowest corner at z = 0, middle at x = y = 0.

    A fixed base is where it is.
    Joints that the posture does not name are at zero, or at the nearest limit to it.

    Raises: NameNotFoundError for a joint or sole frame that does not exist.
    """
    q, base = pin.neutral(model), base_of(model)
    low, high = model.lowerPositionLimit, model.upperPositionLimit
    q[base.nq :] = np.clip(0.0, low[base.nq :], high[base.nq :])
    names = list(model.names)
    joints = names[base.first_joint :]
    for joint, angle in posture.items():
        if joint not in joints:
            raise NameNotFoundError(
                "actuated joint (named by the half-sitting posture)", joint, joints
            )
        q[model.joints[names.index(joint)].idx_q] = angle
    if soles and base is FLOATING:
        q[:3] -= _middle_and_floor(model, q, soles)
    return q


def _middle_and_floor(model: pin.Model, q: np.ndarray, soles: tuple[Sole, ...]) -> np.ndarray:
    """Return the x and y of the soles' middle and the z of their lowest corner [m], world axes."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    frames = {frame.name: index for index, frame in enumerate(model.frames)}
    origins, corners = [], []
    for sole in soles:
        if sole.frame not in frames:
            raise NameNotFoundError(f"frame (wanted by sole {sole.name!r})", sole.frame, frames)
        placement = data.oMf[frames[sole.frame]]
        origins.append(placement.translation.copy())
        corners += [placement.act(corner) for corner in sole.corners]
    middle = np.mean(origins, axis=0)
    return np.array([middle[0], middle[1], min(corner[2] for corner in corners)])


def _posture(extras: Extras, semantics: Semantics | None) -> dict[str, float]:
    if extras.half_sitting is not None:
        return dict(extras.half_sitting)
    return semantics.postures.get(HALF_SITTING, {}) if semantics else {}
