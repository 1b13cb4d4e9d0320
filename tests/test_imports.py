"""The one-way flow as a rule: which room may import which, and no circle between files."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import equipoise

ROOT = Path(equipoise.__file__).parent

KINEMATIC = {"errors", "compiled", "spatial", "robots", "kinematics"}
CONTROL = {*KINEMATIC, "collision", "trajectories", "contacts", "hqp", "tasks", "motion", "control"}
BUILT = {*CONTROL, "wbc", "physics", "scenarios", "runlog", "simulation"}

# room: rooms it may import (itself is always allowed); what stands for itself is listed as a file
BELOW = {
    "errors": set(),
    "compiled": {"errors"},
    "runlog": {"errors"},
    "spatial": {"errors", "compiled"},
    "robots": {"errors", "spatial"},
    "kinematics": KINEMATIC,
    "trajectories": {"errors", "compiled", "spatial"},
    "collision": KINEMATIC,
    "contacts": {*KINEMATIC, "trajectories"},
    "hqp": {"errors", "compiled"},
    "tasks": {*KINEMATIC, "collision", "trajectories", "contacts", "hqp"},
    "motion": {*KINEMATIC, "collision", "trajectories", "contacts", "hqp", "tasks"},
    "control": {*KINEMATIC, "trajectories", "contacts", "hqp"},
    "wbc": CONTROL,
    "physics": {*KINEMATIC, "collision", "contacts"},
    "scenarios": {"errors", "spatial", "robots"},
    "simulation": BUILT,
    "analysis": BUILT,
    "verify": BUILT,
    "bench": {*BUILT, "console"},
    "viewer": {*BUILT, "analysis"},
    "console": {"errors", "robots"},
    "api": {*BUILT, "analysis"},
    "cli": {*BUILT, "analysis", "verify", "bench", "viewer", "console", "api"},
}


@cache
def imports_of(path: Path) -> dict[str, frozenset[str]]:
    """Return by imported module the names taken from it, wherever in the file that happens."""
    found: dict[str, set[str]] = {}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            for alias in node.names:
                found.setdefault(alias.name, set())
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.setdefault(node.module, set()).update(alias.name for alias in node.names)
    return {name: frozenset(taken) for name, taken in found.items() if name.startswith("equipoise")}


def rooms_of(path: Path) -> set[str]:
    rooms = set()
    for name, taken in imports_of(path).items():
        parts = name.split(".")
        rooms |= {parts[1]} if len(parts) > 1 else set(taken) - {"__version__"}
    return rooms


def test_every_room_is_in_the_table():
    rooms = {p.stem for p in ROOT.iterdir() if p.is_dir() or p.suffix == ".py"}
    assert rooms - {"__init__", "__main__", "__pycache__"} == set(BELOW)


@pytest.mark.parametrize("room", sorted(BELOW))
def test_rooms_import_only_what_is_below_them(room):
    place = ROOT / room
    files = sorted(place.rglob("*.py")) if place.is_dir() else [ROOT / f"{room}.py"]
    for path in files:
        extra = rooms_of(path) - BELOW[room] - {room}
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
