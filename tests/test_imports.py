"""The one-way flow as a rule: which room may import which."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import equipoise

ROOT = Path(equipoise.__file__).parent

KERNELS = {"compilation", "scratch", "spatial_kernels", "kinematics_kernels"}
KINEMATIC = {*KERNELS, "errors", "spatial", "robots", "kinematics"}

# room: rooms it may import (itself is always allowed)
BELOW = {
    "errors": set(),
    "compilation": set(),
    "scratch": set(),
    "spatial": {"errors"},
    "spatial_kernels": {"compilation", "scratch"},
    "live_views": {"errors", "spatial"},
    "kinematics_kernels": {"compilation", "spatial_kernels"},
    "robots": {"errors", "spatial"},
    "hqp": {"errors", "compilation"},
    "runlog": {"errors"},
    "kinematics": {*KERNELS, "errors", "spatial", "robots", "live_views"},
    "coordinates": {"errors", "spatial"},
    "world": {"errors", "spatial", "robots", "kinematics"},
    "distances": {*KINEMATIC, "live_views", "world", "distance_kernels"},
    "distance_kernels": {"compilation", "spatial_kernels"},
    "contacts": KINEMATIC,
    "tasks": {*KINEMATIC, "world", "distances", "distance_kernels", "contacts", "hqp"},
    "motion": {*KINEMATIC, "hqp", "tasks"},
    "control": {*KINEMATIC, "contacts"},
    "physics": {*KINEMATIC, "contacts", "world"},
    "bench": {
        *(*KINEMATIC, "world", "contacts", "tasks", "hqp", "motion", "control", "physics"),
        *("scenarios", "console"),
    },
}


def imports_of(path: Path) -> set[str]:
    rooms = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
        rooms |= {n.split(".")[1] for n in names if n.startswith("equipoise.")}
    return rooms


@pytest.mark.parametrize("room", sorted(BELOW))
def test_rooms_import_only_what_is_below_them(room):
    place = ROOT / room
    files = sorted(place.rglob("*.py")) if place.is_dir() else [ROOT / f"{room}.py"]
    for path in files:
        if path.exists():
            extra = imports_of(path) - BELOW[room] - {room}
            assert not extra, f"{path.relative_to(ROOT)} imports {sorted(extra)}"


def test_every_module_says_why_it_exists():
    for path in ROOT.rglob("*.py"):
        docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
        assert docstring, f"{path.relative_to(ROOT)} has no first line"


def test_importing_the_package_is_light():
    code = "import sys, equipoise, equipoise.cli; print(sorted(sys.modules))"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    for heavy in ("'numpy'", "'pinocchio'", "'numba'", "'matplotlib'"):
        assert heavy not in loaded


def test_what_the_package_offers_exists():
    for name in equipoise.__all__:
        assert getattr(equipoise, name) is not None
    with pytest.raises(AttributeError, match="nothing_like_it"):
        equipoise.nothing_like_it  # noqa: B018
