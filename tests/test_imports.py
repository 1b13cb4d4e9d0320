"""The one-way flow as a rule: which room may import which, and no circle between files."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

import equipoise

ROOT = Path(equipoise.__file__).parent

KINEMATIC = {
    "errors",
    "given",
    "optional",
    "bounded_yaml",
    "compiled",
    "spatial",
    "robots",
    "kinematics",
}
CONTROL = {
    *(*KINEMATIC, "collision", "trajectories", "contacts", "hqp", "tasks", "motion", "control"),
    "renamed",
}
BUILT = {*CONTROL, "walking", "wbc", "physics", "scenarios", "runlog", "wire", "simulation"}

# room: rooms it may import (itself is always allowed); what stands for itself is listed as a file
BELOW = {
    "errors": set(),
    "given": {"errors"},
    "optional": {"errors"},
    "renamed": set(),
    "distances": {"renamed"},
    "world": {"renamed"},
    "bounded_yaml": {"errors"},
    "compiled": {"errors"},
    "runlog": {"errors"},
    "spatial": {"errors", "compiled"},
    "robots": {"errors", "given", "optional", "bounded_yaml", "spatial", "kinematics"},
    "kinematics": {"errors", "compiled", "spatial"},
    "trajectories": {"errors", "compiled", "spatial"},
    "collision": KINEMATIC,
    "contacts": {*KINEMATIC, "trajectories"},
    "hqp": {"errors", "optional", "compiled"},
    "tasks": {*KINEMATIC, "collision", "trajectories", "contacts", "hqp", "renamed"},
    "motion": {*KINEMATIC, "collision", "trajectories", "contacts", "hqp", "tasks"},
    "walking": {*KINEMATIC, "trajectories", "contacts"},
    "control": {*KINEMATIC, "trajectories", "contacts", "hqp", "renamed"},
    "wbc": CONTROL,
    "physics": {*KINEMATIC, "collision", "contacts"},
    "adapters": {*KINEMATIC, "contacts", "physics"},
    "gym": {*CONTROL, "wbc", "physics"},
    "scenarios": {"errors", "bounded_yaml", "spatial", "robots"},
    "wire": {*KINEMATIC, "trajectories", "contacts"},
    "estimation": {*KINEMATIC, "trajectories", "contacts", "wire"},
    "simulation": BUILT,
    "remote": {*BUILT, "estimation"},
    "analysis": BUILT,
    "verify": BUILT,
    "bench": {*BUILT, "console"},
    "viewer": {*BUILT, "analysis"},
    "studies": {*BUILT, "analysis"},
    "console": {"errors", "robots"},
    "api": {*BUILT, "analysis"},
    "cli": {
        *(*BUILT, "analysis", "verify", "bench", "viewer", "studies", "console", "remote", "api"),
    },
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


def file_of(module: str) -> Path | None:
    place = ROOT.parent.joinpath(*module.split("."))
    for path in (place.with_suffix(".py"), place / "__init__.py"):
        if path.is_file():
            return path
    return None


def files_of(path: Path) -> set[Path]:
    """Return the files that a file takes something from, those that only pass names on left out."""
    found = set()
    for name, taken in imports_of(path).items():
        modules = [name, *(f"{name}.{one}" for one in taken)]
        found |= {f for f in map(file_of, modules) if f is not None}
        home = file_of(name)
        if home is not None and home.name == "__init__.py":
            sources = imports_of(home).items()
            found |= {f for n, given in sources if given & taken and (f := file_of(n)) is not None}
    return {f for f in found if f != path and f.name != "__init__.py"}


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


def test_no_files_import_each_other_in_a_circle():
    circles, done = [], set()

    def walk(path: Path, trail: tuple[Path, ...]) -> None:
        if path in trail:
            circles.append([p.relative_to(ROOT).as_posix() for p in trail[trail.index(path) :]])
        elif path not in done:
            for other in sorted(files_of(path)):
                walk(other, (*trail, path))
            done.add(path)

    for path in sorted(ROOT.rglob("*.py")):
        walk(path, ())
    assert not circles


def test_the_table_itself_has_no_circle():
    done: set[str] = set()
    while len(done) < len(BELOW):
        free = {room for room, below in BELOW.items() if below - {room} <= done} - done
        assert free, f"these stand above each other: {sorted(set(BELOW) - done)}"
        done |= free


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


def test_a_type_checker_sees_what_the_package_offers():
    """The table of homes, the imports for type checkers and `__all__` say the same."""
    tree = ast.parse((ROOT / "__init__.py").read_text(encoding="utf-8"))
    [checked] = [node for node in tree.body if isinstance(node, ast.If)]
    seen = {
        alias.name: statement.module
        for statement in checked.body
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    }
    assert seen == equipoise._HOMES
    assert sorted(seen) == equipoise.__all__
    for name, home in seen.items():
        module = import_module(home)
        assert name in getattr(module, "__all__", vars(module))


def test_the_version_is_the_same_wherever_it_is_written():
    project = tomllib.loads((ROOT.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    assert equipoise.__version__ == project["project"]["version"]
