"""Says everything that is wrong with a robot description, for a person who wants to mend it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from equipoise.errors import InputError
from equipoise.robots.files.base import take_base
from equipoise.robots.files.check_tree import check_tree
from equipoise.robots.files.finding import ERROR, Finding
from equipoise.robots.files.mjcf.text import is_mjcf
from equipoise.robots.files.planar_base import without_wheels
from equipoise.robots.files.source import find_source
from equipoise.robots.load import load_and_check


def check_urdf(
    path: str | Path,
    *,
    srdf_path: str | Path | None = None,
    extras_path: str | Path | None = None,
    package_dirs: Sequence[str | Path] = (),
) -> list[Finding]:
    """Return all errors and warnings of a URDF, an MJCF, or a robot's YAML or folder.

    None means that it is sound.
    Never raises for a bad file: what `load_robot` would raise is among the findings.
    """
    try:
        source = find_source(path, srdf_path=srdf_path, extras_path=extras_path)
        urdf = source.urdf
        findings: list[Finding] = []
        if not is_mjcf(urdf):
            tree, base = take_base(source.tree()[0], without_wheels(source.extras.base))
            _, findings = check_tree(tree, urdf, package_dirs, base)
    except InputError as error:
        return [Finding(ERROR, Path(path).name, str(error))]
    if any(finding.severity == ERROR for finding in findings):
        return findings
    try:
        _, findings = load_and_check(
            path, srdf_path=srdf_path, extras_path=extras_path, package_dirs=package_dirs
        )
    except InputError as error:
        return [*findings, Finding(ERROR, urdf.name, str(error))]
    return findings
