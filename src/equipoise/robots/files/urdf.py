"""From a URDF, its SRDF and its YAML to what a robot is made of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pinocchio as pin

from equipoise.errors import quoted
from equipoise.robots.base import require_joints_of_one_dof
from equipoise.robots.files.base import take_base
from equipoise.robots.files.build import (
    build_geometry,
    build_model,
    neighbouring_links,
)
from equipoise.robots.files.check_tree import check_tree
from equipoise.robots.files.described import Described
from equipoise.robots.files.finding import WARNING, Finding, raise_errors
from equipoise.robots.files.source import Source
from equipoise.robots.files.srdf import Semantics, read_srdf

HALF_SITTING = "half_sitting"


def describe_urdf(
    source: Source, base: str | None, package_dirs: Sequence[str | Path] = ()
) -> Described:
    """Return the robot of a URDF that was checked before.

    Raises: RobotFileError with what is wrong, NameNotFoundError.
    """
    tree, laws, locked = source.tree()
    tree, kind = take_base(tree, base)
    checked, findings = check_tree(tree, source.urdf, package_dirs, kind)
    raise_errors(source.urdf, findings)
    semantics = read_srdf(source.srdf) if source.srdf else None
    model = build_model(checked, kind)
    require_joints_of_one_dof(model)
    capsules = source.extras.has_capsules
    collision = build_geometry(checked, model, pin.GeometryType.COLLISION, as_capsules=capsules)
    visual = build_geometry(checked, model, pin.GeometryType.VISUAL, as_capsules=capsules)
    disabled = set(semantics.disabled_pairs) if semantics else neighbouring_links(model, collision)
    postures = semantics.postures if semantics else {}
    return Described(
        checked.get("name") or source.urdf.stem, model, collision, visual, kind, disabled,
        postures, HALF_SITTING if HALF_SITTING in postures else None,
        [*findings, *unknown_links(source.srdf, semantics, model)], locked, laws,
    )  # fmt: skip


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
