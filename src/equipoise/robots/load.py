"""Loads a robot: check the text, build with Pinocchio, check the model, wrap it frozen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin

from equipoise.errors import NameNotFoundError
from equipoise.robots.base import FLOATING, actuated_joints, base_of
from equipoise.robots.files.build import add_collision_pairs, take_hulls
from equipoise.robots.files.check_model import check_model
from equipoise.robots.files.couple import couple
from equipoise.robots.files.described import Described
from equipoise.robots.files.finding import WARNING, Finding, raise_errors, tell_warnings
from equipoise.robots.files.mjcf.read import describe_mjcf
from equipoise.robots.files.mjcf.text import is_mjcf
from equipoise.robots.files.place_base import place_base
from equipoise.robots.files.planar_base import PLANAR, roll_base, without_wheels
from equipoise.robots.files.source import Source, find_source
from equipoise.robots.files.urdf import describe_urdf
from equipoise.robots.robot import Foot, Palm, Robot, Sole


def load_robot(
    urdf_path: str | Path,
    *,
    srdf_path: str | Path | None = None,
    extras_path: str | Path | None = None,
    package_dirs: Sequence[str | Path] = (),
    base: str | None = None,
) -> Robot:
    """Load a robot from its URDF or MJCF, its YAML, or the folder of either.

    `base` is "floating", "fixed" or "planar"; without it the YAML decides, and else the URDF: a
    first link called `world` is fixed, any other floats. An MJCF floats if it has a free joint.

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
    wanted = base or source.extras.base
    described = _described(source, without_wheels(wanted), package_dirs)
    if wanted == PLANAR:
        roll_base(described, source.extras.wheels)
    robot = _built(source, described)
    return robot, described.findings


def _described(source: Source, base: str | None, package_dirs: Sequence[str | Path]) -> Described:
    if is_mjcf(source.urdf):
        return describe_mjcf(source.urdf, source.extras, base)
    return describe_urdf(source, base, package_dirs)


def _built(source: Source, described: Described) -> Robot:
    """Return the robot of a description; add what is found while it is built.

    Raises: RobotFileError, NameNotFoundError.
    """
    extras = source.extras
    place_base(described, extras.base_at)
    couple(described)
    model, collision = described.model, described.collision
    described.findings += take_hulls(model, collision)
    add_collision_pairs(model, collision, described.disabled)
    soles = tuple(Sole(**entry.model_dump()) for entry in extras.soles)
    feet = tuple(Foot(**entry.model_dump()) for entry in extras.feet)
    posture = extras.half_sitting
    if posture is None:
        posture = described.postures[described.start] if described.start else {}
    posture = {name: q for name, q in posture.items() if name not in described.coupled}
    q = half_sitting_configuration(model, posture, soles, feet)
    raise_errors(source.urdf, check_model(model, q))
    if not (soles or feet) and described.base is FLOATING:
        ways = "or feet that are points, or say base: fixed there"
        remedy = f"List the soles in {source.yaml.name}, {ways}"
        described.findings.append(
            Finding(WARNING, "robot", "no soles: it cannot stand", remedy=remedy)
        )
    return Robot(
        name=extras.name or described.name or source.urdf.stem,
        model=model,
        collision_model=collision,
        visual_model=described.visual,
        urdf_path=source.urdf.resolve(),
        soles=soles,
        palms=tuple(Palm(**entry.model_dump()) for entry in extras.palms),
        camera=extras.camera,
        q_half_sitting=q,
        parts=extras.links_of_parts,
        postures=described.postures,
        feet=feet,
    )


def half_sitting_configuration(
    model: pin.Model,
    posture: dict[str, float],
    soles: tuple[Sole, ...],
    feet: tuple[Foot, ...] = (),
) -> np.ndarray:
    """Return q (nq,): upright base, the lowest of soles and feet at z = 0, middle at x = y = 0.

    A fixed base stays where it is.
    Joints that the posture does not name are at zero, or at the nearest limit to it.

    Raises: NameNotFoundError for a joint or sole frame that does not exist.
    """
    q, base = pin.neutral(model), base_of(model)
    low, high = model.lowerPositionLimit, model.upperPositionLimit
    q[base.nq :] = np.clip(0.0, low[base.nq :], high[base.nq :])
    names = list(model.names)
    joints = [names[joint] for joint in actuated_joints(model)]
    for joint, angle in posture.items():
        if joint not in joints:
            raise NameNotFoundError(
                "actuated joint (named by the half-sitting posture)", joint, joints
            )
        q[model.joints[names.index(joint)].idx_q] = angle
    if (soles or feet) and base is FLOATING:
        q[:3] -= _middle_and_floor(model, q, soles, feet)
    return q


def _middle_and_floor(
    model: pin.Model, q: np.ndarray, soles: tuple[Sole, ...], feet: tuple[Foot, ...]
) -> np.ndarray:
    """Return the x and y of the middle of soles and feet and the z of their lowest point [m]."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    frames = {frame.name: index for index, frame in enumerate(model.frames)}
    origins, corners = [], []
    standing: tuple[Sole | Foot, ...] = (*soles, *feet)
    for one in standing:
        kind = "sole" if isinstance(one, Sole) else "foot"
        if one.frame not in frames:
            raise NameNotFoundError(f"frame (wanted by {kind} {one.name!r})", one.frame, frames)
        placement = data.oMf[frames[one.frame]]
        origins.append(placement.translation.copy())
        if isinstance(one, Sole):
            corners += [placement.act(corner) for corner in one.corners]
        else:
            corners.append(placement.translation - np.array([0.0, 0.0, one.radius]))
    middle = np.mean(origins, axis=0)
    return np.array([middle[0], middle[1], min(corner[2] for corner in corners)])
