"""Reading a tuning file: shipped or one's own, for a robot, small or whole."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from equipoise.studies.read import path_of, plain_of, validated
from equipoise.studies.tune.schema import TuneSpec

FILES = Path(__file__).parent / "files"


def named_tunings() -> dict[str, Path]:
    """Return the path of each shipped tuning file by name."""
    return {path.stem: path for path in sorted(FILES.glob("*.yaml"))}


def read_tune(
    name_or_path: str,
    overrides: Sequence[str] = (),
    *,
    robot: str | None = None,
    small: bool = False,
) -> TuneSpec:
    """Return a shipped tuning file by name, or one from a YAML file; as `read_study` does.

    Raises: `NameNotFoundError`, `ScenarioError`.
    """
    path = path_of(name_or_path, named_tunings(), "tuning file")
    plain, tree = plain_of(path, "tuning file", overrides, robot=robot, small=small)
    return validated(TuneSpec, plain, tree, overrides, str(path))
