"""Reading a study file: shipped or one's own, for a robot, small or whole; errors with lines."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.scenarios.complaints import complaint
from equipoise.scenarios.gains_file import read_gains
from equipoise.scenarios.lookup import at_path
from equipoise.scenarios.overrides import apply_overrides
from equipoise.scenarios.read import placed
from equipoise.scenarios.text_files import text_of_file
from equipoise.scenarios.yaml_tree import load_tree, merged, plain_tree
from equipoise.studies.schema import StudySpec

FILES = Path(__file__).parent / "files"
SMALL, FOR_ROBOT, ONLY = "small", "for_robot", "only"
Model = TypeVar("Model", bound=BaseModel)


def named_studies() -> dict[str, Path]:
    """Return the path of each shipped study by name."""
    return {path.stem: path for path in sorted(FILES.glob("*.yaml"))}


def read_study(
    name_or_path: str,
    overrides: Sequence[str] = (),
    *,
    robot: str | None = None,
    small: bool = False,
) -> StudySpec:
    """Return a shipped study by name, or one from a YAML file.

    What the file says under `for_robot` of a robot's name is written over it, and what it says
    under `small` if that is wanted; then the overrides `path=value` of the study's own keys.
    Raises: `NameNotFoundError`, `ScenarioError`.
    """
    path = path_of(name_or_path, named_studies(), "study")
    plain, tree = plain_of(path, "study", overrides, robot=robot, small=small)
    choose(plain)
    take_gains(plain.get("controllers"), path.parent)
    return validated(StudySpec, plain, tree, overrides, str(path))


def plain_of(
    path: Path, kind: str, overrides: Sequence[str], *, robot: str | None, small: bool
) -> tuple[dict[str, Any], Any]:
    """Return what a file says for a robot, small or whole, and ruamel's tree that knows its lines.

    Raises: `ScenarioError`.
    """
    tree = load_tree(text_of_file(path, kind), str(path), kind)
    plain = plain_tree(tree)
    for_robot, reduced = plain.pop(FOR_ROBOT, {}), plain.pop(SMALL, None)
    robot = robot or plain.get("robot")
    if robot is not None:
        plain = merged({**plain, "robot": robot}, _exceptions(for_robot).get(robot, {}))
    if small:
        if not isinstance(reduced, dict):
            raise ScenarioError(f"this {kind} has no small form", path=SMALL, given=str(path))
        plain = merged(plain, reduced)
    apply_overrides(plain, overrides)
    return plain, tree


def path_of(name_or_path: str, known: dict[str, Path], kind: str) -> Path:
    """Return the path of a shipped file or of one's own. Raises: `NameNotFoundError`."""
    if name_or_path in known:
        return known[name_or_path]
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        raise NameNotFoundError(kind, name_or_path, known, remedy="A path must end in .yaml.")
    return path


def validated(
    model: type[Model], plain: Any, tree: Any, overrides: Sequence[str], source: str
) -> Model:
    """Return the object that a tree describes. Raises: `ScenarioError` with file and line."""
    try:
        return model.model_validate(plain)
    except ValidationError as error:
        raise placed(complaint(error, plain, tree, model), overrides, source) from None


def choose(plain: dict[str, Any]) -> None:
    """Keep of the controllers those that `only` names, in its order. Raises: `ScenarioError`."""
    only, controllers = plain.pop(ONLY, None), plain.get("controllers")
    if only is None or not isinstance(controllers, dict):
        return
    if not isinstance(only, list) or not only:
        raise ScenarioError("wanted a list of names of controllers", path=ONLY, given=only)
    for name in only:
        if name not in controllers:
            raise at_path(NameNotFoundError("controller", str(name), controllers), ONLY)
    plain["controllers"] = {name: controllers[name] for name in only}


def take_gains(controllers: Any, folder: Path) -> None:
    """Put what a controller's file of gains says in its place, below what it sets itself."""
    if not isinstance(controllers, dict):
        return  # the schema will say so
    for contender in controllers.values():
        if isinstance(contender, dict) and isinstance(contender.get("gains"), str):
            values = read_gains(folder / contender.pop("gains"))
            contender["set"] = {**values, **(contender.get("set") or {})}


def _exceptions(for_robot: Any) -> dict[str, Any]:
    if not isinstance(for_robot, dict) or not all(isinstance(x, dict) for x in for_robot.values()):
        raise ScenarioError("wanted a mapping from robots to what is different", path=FOR_ROBOT)
    return for_robot
