"""The scenarios that come with the package, and reading one by name or path."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.scenarios.read import parse_scenario
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
        _text_of(name_or_path),
        overrides,
        source=Path(name_or_path).name,
        text_of=_text_of,
        robot=robot,
    )


def _text_of(name_or_path: str) -> str:
    known = named_scenarios()
    path = known.get(name_or_path)
    if path is None:
        path = Path(name_or_path)
        if path.suffix not in (".yaml", ".yml"):
            raise NameNotFoundError(
                "scenario", name_or_path, known, remedy="A path must end in .yaml."
            )
    try:
        if path.exists() and not path.is_file():
            raise ScenarioError("the scenario is not a file", path=str(path), known=known)
        if path.stat().st_size > MOST_BYTES:
            raise ScenarioError(
                f"the scenario file is larger than {MOST_BYTES // 1_000_000} MB", path=str(path)
            )
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:  # ValueError: not UTF-8, or no path at all
        raise ScenarioError(
            f"cannot read the scenario file: {_plainly(error)}", path=str(path), known=known
        ) from None


def _plainly(error: OSError | ValueError) -> str:
    """Return what went wrong without the bytes or the path it went wrong with."""
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start} is not UTF-8 text"
    return str(getattr(error, "strerror", None) or error)
