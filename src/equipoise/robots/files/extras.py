"""Reads a robot's YAML and says on which line it is wrong."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from equipoise.bounded_yaml import BadYamlError, load_yaml
from equipoise.errors import RobotFileError, one_line
from equipoise.robots.files.extras_schema import Extras

MAX_EXTRAS_BYTES = 1_000_000


def read_extras(path: Path) -> Extras:
    """Read and validate an extras file.

    Raises: RobotFileError naming the file, the line and the known keys.
    """
    tree = _read_yaml(path)
    if tree is None:
        return Extras()
    if not isinstance(tree, dict):
        raise RobotFileError(
            f"{path}: the file must be a mapping of keys",
            given=type(tree).__name__,
            known=Extras.model_fields,
        )
    try:
        return Extras.model_validate(tree)
    except ValidationError as error:
        raise _explained(path, tree, error) from error


def _read_yaml(path: Path) -> object:
    try:
        if not path.is_file():
            raise RobotFileError(f"There is no file {path}", remedy="Give the path of a YAML file")
        if path.stat().st_size > MAX_EXTRAS_BYTES:
            raise RobotFileError(f"{path} is larger than {MAX_EXTRAS_BYTES} bytes")
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise RobotFileError(f"Cannot read the extras file {path}: {one_line(error)}") from error
    try:
        return load_yaml(text)
    except BadYamlError as error:
        where = f"{path}, line {error.line}" if error.line is not None else f"{path}"
        raise RobotFileError(f"{where}: {error.problem}", remedy=error.remedy) from error


def _explained(path: Path, tree: object, error: ValidationError) -> RobotFileError:
    """Turn pydantic's first complaint into a sentence with line and known keys."""
    complaints = error.errors()
    first = complaints[0]
    where = ".".join(str(part) for part in first["loc"] if part != "SourceEntry") or "the file"
    known: Iterable[str] = _schema_at(first["loc"]).model_fields
    problem, given, hint = first["msg"].removeprefix("Value error, "), first["input"], ""
    if first["type"] not in ("extra_forbidden", "missing"):
        known = ()  # the key is right, its value is not
    if first["type"] == "extra_forbidden":
        near = get_close_matches(str(first["loc"][-1]), known, n=1)
        problem, given = "unknown key", None
        hint = f"Did you mean {near[0]!r}? " if near else ""
    more = f"{len(complaints) - 1} more like this" if len(complaints) > 1 else ""
    return RobotFileError(
        f"{path}, line {_line_of(tree, first['loc'])}, {where}: {problem}",
        given=None if isinstance(given, (dict, list)) else given,
        known=known,
        remedy=(hint + more).strip(),
    )


def _schema_at(location: tuple[int | str, ...]) -> type[BaseModel]:
    """Return the innermost section of the file that holds a location."""
    annotation: Any = Extras
    found: type[BaseModel] = Extras
    for part in location:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            found = annotation
            field = annotation.model_fields.get(str(part))
            annotation = field.annotation if field is not None else None
        else:
            annotation = _inside(annotation)
        annotation = _only_section(annotation)
    return found


def _inside(annotation: Any) -> Any:
    """Return what a mapping or list holds."""
    held = [argument for argument in get_args(annotation) if argument is not Ellipsis]
    return held[-1] if held else None


def _only_section(annotation: Any) -> Any:
    """Return the section or container of an optional annotation."""
    if getattr(annotation, "__origin__", None) in (dict, tuple, list):
        return annotation
    members = [m for m in get_args(annotation) if m is not type(None)]
    sections = [m for m in members if isinstance(m, type) and issubclass(m, BaseModel)]
    containers = [m for m in members if getattr(m, "__origin__", None) in (dict, tuple)]
    return next(iter([*sections, *containers]), annotation)


def _line_of(tree: Any, location: tuple[int | str, ...]) -> int:
    """Return the line (from 1) of the deepest key that leads to a location."""
    line = tree.lc.line + 1 if hasattr(tree, "lc") else 1
    for part in location:
        try:
            find = tree.lc.key if hasattr(tree, "keys") else tree.lc.item
            line = find(part)[0] + 1
            tree = tree[part]
        except (AttributeError, KeyError, IndexError, TypeError):
            break
    return line
