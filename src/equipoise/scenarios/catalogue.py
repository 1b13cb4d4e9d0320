"""The scenarios that come with the package, and reading one by name or path."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.scenarios.read import line_of, parse_scenario, placed
from equipoise.scenarios.schema import Scenario

MOST_BYTES = 4_000_000
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
    remedy = "Give a YAML file, or the name of a shipped scenario"
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):  # a pipe or a device
            raise ScenarioError(f"{path} is not a file", known=known, remedy=remedy)
        if path.stat().st_size > MOST_BYTES:
            size = f"{MOST_BYTES // 1_000_000} MB"
            raise ScenarioError(f"{path}: the scenario file is larger than {size}", remedy=remedy)
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        problem = f"there is no file {path}"
        raise ScenarioError(problem, known=known, remedy=remedy) from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{path} is no text, hence no scenario", remedy=remedy) from None
    except (OSError, ValueError) as error:  # ValueError: no path at all
        why = str(getattr(error, "strerror", None) or error).lower()
        raise ScenarioError(f"{path} cannot be read: {why}", remedy=remedy) from None
    if not text.isprintable() and any(ord(c) < 32 and c not in "\t\n\r\f" for c in text):
        raise ScenarioError(f"{path} is no text, hence no scenario", remedy=remedy)
    return text
