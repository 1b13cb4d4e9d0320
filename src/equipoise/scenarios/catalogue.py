"""The scenarios that come with the package, and reading one by name or path."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.scenarios.read import line_of, parse_scenario, placed
from equipoise.scenarios.schema import Scenario
from equipoise.scenarios.text_files import text_of_file

_FOLDER = Path(__file__).parent / "files"


def named_scenarios() -> dict[str, Path]:
    """Return the path of each shipped scenario by name."""
    return {path.stem: path for path in sorted(_FOLDER.glob("*.yaml"))}


def read_scenario(
    name_or_path: str, overrides: Sequence[str] = (), *, robot: str | None = None
) -> Scenario:
    """Return a shipped scenario by name, or one from a YAML file; retargeted to `robot` if given.

    Raises: `NameNotFoundError`, `ScenarioError`, `RobotFileError`.
    """
    return parse_scenario(
        _text_of(name_or_path), overrides, source=name_or_path, text_of=_text_of, robot=robot
    )


def place_error(error: ScenarioError, name_or_path: str, overrides: Sequence[str]) -> ScenarioError:
    """Return a complaint that came up late with the override, or the line of the file, it means."""
    if error.path and not error.line and "--set " not in error.problem:
        found = placed(error, overrides)
        if found is not error or name_or_path in named_scenarios():
            return found
        return error.at(name_or_path, line=line_of(_text_of(name_or_path), error.path))
    return error


def _text_of(name_or_path: str) -> str:
    known = named_scenarios()
    path = known.get(name_or_path)
    if path is None:
        path = Path(name_or_path)
        if path.suffix not in (".yaml", ".yml"):
            raise NameNotFoundError(
                "scenario", name_or_path, known, remedy="A path must end in .yaml."
            )
    return text_of_file(path, "scenario", known)
