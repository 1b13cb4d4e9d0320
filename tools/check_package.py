"""Check what `python -m build` made: nothing is missing in wheel and sdist, and the wheel works.

    python tools/check_package.py dist

The wheel is installed with its dependencies into an environment of its own, away from the sources:
the command line answers there, and a scenario runs for 50 ms.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import venv
import zipfile
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WITH_SDIST = ("src", "tests", "docs", "examples", "tools", "benchmarks")
BESIDE = ("README.md", "CHANGELOG.md", "LICENSE", "NOTICE", "Makefile", "pyproject.toml")
SMOKE = """
import sys, equipoise
from pathlib import Path
where = Path(equipoise.__file__)
assert Path(sys.prefix) in where.parents, where
assert equipoise.__version__ == sys.argv[1], equipoise.__version__
assert (where.parent / "py.typed").is_file()
robot = equipoise.get_robot("hrp2")
run = equipoise.load_run("run")
assert run.complete and len(run.t) == 50 and run["q"].shape == (50, robot.nq), run
"""


def main(dist: str) -> None:
    """Check the one wheel and the one sdist in a folder."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    wheel = Path(dist).resolve() / f"equipoise-{version}-py3-none-any.whl"
    sdist = Path(dist).resolve() / f"equipoise-{version}.tar.gz"
    check_wheel(wheel)
    check_sdist(sdist, f"equipoise-{version}")
    with tempfile.TemporaryDirectory() as folder:
        try_wheel(wheel, version, Path(folder))
    print(f"{wheel.name} and {sdist.name} are whole, and the wheel works.")


def check_wheel(wheel: Path) -> None:
    """Refuse a wheel that lacks a file of the package, or holds one from elsewhere."""
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
    wanted = {name.removeprefix("src/") for name in sources(["src"])}
    _refuse(wheel.name, "lacks", wanted - held)
    _refuse(wheel.name, "should not hold", {n for n in held - wanted if ".dist-info/" not in n})


def check_sdist(sdist: Path, top: str) -> None:
    """Refuse an sdist that lacks sources, tests, documentation, examples or licence."""
    with tarfile.open(sdist) as archive:
        held = {name.removeprefix(f"{top}/") for name in archive.getnames()}
    _refuse(sdist.name, "lacks", {*sources(WITH_SDIST), *BESIDE} - held)


def sources(folders: Iterable[str]) -> set[str]:
    """Return the files that git knows in some folders, as paths from the root."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", *folders], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return {name for name in listed.stdout.split("\0") if name}


def try_wheel(wheel: Path, version: str, folder: Path) -> None:
    """Install the wheel into an environment in `folder`, run it there and look at what it did."""
    venv.create(folder / "venv", with_pip=True)
    commands = folder / "venv" / "bin"
    _call(folder, commands / "pip", "install", "--quiet", "--disable-pip-version-check", wheel)
    told = _call(folder, commands / "equipoise", "--version")
    if version not in told:
        sys.exit(f"equipoise --version says {told!r}, wanted {version}")
    for name in ("tray", "press"):
        if name not in _call(folder, commands / "equipoise", "scenarios"):
            sys.exit(f"equipoise scenarios does not list {name}")
    run = ("run", "tray", "--set", "duration=0.05", "--no-figures", "--out", "run")
    _call(folder, commands / "equipoise", *run, allowed=(0, 1))  # 1: too short to meet anything
    _call(folder, commands / "python", "-c", SMOKE, version)
    _call(folder, commands / "equipoise", "export", "run")


def _call(folder: Path, *command: str | Path, allowed: tuple[int, ...] = (0,)) -> str:
    """Run a command in `folder`, where no source is imported, and return what it says."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode not in allowed:
        shown = " ".join(str(part) for part in command)
        sys.exit(f"{shown}\nended with {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def _refuse(archive: str, fault: str, names: set[str]) -> None:
    if names:
        sys.exit(f"{archive} {fault}: {', '.join(sorted(names)[:20])}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
