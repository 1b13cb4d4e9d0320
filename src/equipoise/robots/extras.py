"""What a robot has beyond URDF and SRDF: soles, palms, camera; read from YAML and validated."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from ruamel.yaml import YAML
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from equipoise.errors import RobotFileError

MAX_EXTRAS_BYTES = 1_000_000
Name = Annotated[str, Field(min_length=1, strict=True)]
Metre = Annotated[float, Field(allow_inf_nan=False, ge=-10.0, le=10.0, strict=True)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class SoleEntry(_Strict):
    """A sole's rectangle [m] in the axes of its frame."""

    name: Name
    frame: Name
    x_min: Metre
    x_max: Metre
    y_min: Metre
    y_max: Metre

    @model_validator(mode="after")
    def _bounds_in_order(self) -> SoleEntry:
        if self.x_min >= self.x_max or self.y_min >= self.y_max:
            raise ValueError("a sole needs x_min < x_max and y_min < y_max")
        return self


class PalmEntry(_Strict):
    """A hand's contact frame."""

    name: Name
    frame: Name


class Extras(_Strict):
    """The whole extras file; every key may be left out."""

    name: Name | None = None
    cylinders_are_capsules: bool = False
    soles: tuple[SoleEntry, ...] = ()
    palms: tuple[PalmEntry, ...] = ()
    camera: Name | None = None
    half_sitting: dict[Name, Annotated[float, Field(allow_inf_nan=False, strict=True)]] | None = (
        None
    )

    @model_validator(mode="after")
    def _unique_names(self) -> Extras:
        for kind, entries in (("sole", self.soles), ("palm", self.palms)):
            names = [entry.name for entry in entries]
            repeated = sorted({name for name in names if names.count(name) > 1})
            if repeated:
                raise ValueError(f"{kind} name given twice: {', '.join(repeated)}")
        return self


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
        if path.stat().st_size > MAX_EXTRAS_BYTES:
            raise RobotFileError(f"{path} is larger than {MAX_EXTRAS_BYTES} bytes")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RobotFileError(f"Cannot read the extras file {path}: {error}") from error
    reader = YAML(typ="rt", pure=True)
    reader.version = (1, 2)
    try:
        return reader.load(text)
    except DuplicateKeyError as error:
        raise RobotFileError(
            f"{path}, line {_line(error)}: a key is given twice", remedy="Keep one of the two"
        ) from error
    except MarkedYAMLError as error:
        raise RobotFileError(
            f"{path}, line {_line(error)}: not valid YAML: {error.problem or error.context}"
        ) from error
    except (YAMLError, ValueError, RecursionError) as error:
        raise RobotFileError(f"{path}: not valid YAML: {error}") from error


def _line(error: MarkedYAMLError) -> int | str:
    mark = error.problem_mark or error.context_mark
    return "?" if mark is None else mark.line + 1


def _explained(path: Path, tree: object, error: ValidationError) -> RobotFileError:
    """Turn pydantic's first complaint into a sentence with line and known keys."""
    complaints = error.errors()
    first = complaints[0]
    where = ".".join(str(part) for part in first["loc"]) or "the file"
    known = _schema_at(first["loc"]).model_fields
    problem, given, hint = first["msg"].removeprefix("Value error, "), first["input"], ""
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
    if location[:1] == ("soles",) and len(location) > 1:
        return SoleEntry
    if location[:1] == ("palms",) and len(location) > 1:
        return PalmEntry
    return Extras


def _line_of(tree: object, location: tuple[int | str, ...]) -> int:
    """Return the line (from 1) of the deepest key on the way to a location."""
    line = tree.lc.line + 1 if hasattr(tree, "lc") else 1
    for part in location:
        try:
            place = tree.lc.key(part) if isinstance(tree, dict) else tree.lc.item(part)
            line = place[0] + 1
            tree = tree[part]
        except (AttributeError, KeyError, IndexError, TypeError):
            break
    return line
