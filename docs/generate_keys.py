"""Write the tables of scenario keys and metrics from the code, so that they cannot drift.

`python docs/generate_keys.py` writes `docs/scenario_keys.md`; building the site does so too, and a
test compares the file with what would be written.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from equipoise.analysis.metrics import METRICS
from equipoise.scenarios import schema

TARGET = Path(__file__).parent / "scenario_keys.md"
HEAD = """<!-- Written by docs/generate_keys.py from the code: do not edit. -->

# Every key of a scenario

Lengths are in metres, angles in radians, times in seconds, forces in newtons. A key without a
default must be given. NaN, infinities and unknown keys are refused everywhere.
"""
BOUNDS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}


def write_tables() -> bool:
    """Write the page if it differs from what is there; return whether it did."""
    text = tables()
    if TARGET.exists() and TARGET.read_text(encoding="utf-8") == text:
        return False
    TARGET.write_text(text, encoding="utf-8")
    return True


def tables() -> str:
    """Return the whole page."""
    parts = [HEAD, *map(_section, _models(schema.Scenario)), _metrics()]
    return "\n".join(parts)


def _models(model: type[BaseModel], seen: set[type] | None = None) -> Iterator[type[BaseModel]]:
    """Yield a model and every model that its fields mention, each once, outer ones first."""
    seen = set() if seen is None else seen
    if model in seen:
        return
    seen.add(model)
    yield model
    for field in model.model_fields.values():
        for inner in _mentioned(field.annotation):
            yield from _models(inner, seen)


def _mentioned(annotation: Any) -> list[type[BaseModel]]:
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _mentioned(part)]


def _section(model: type[BaseModel]) -> str:
    lines = [f"## {_title(model)}\n", inspect.cleandoc(model.__doc__ or ""), ""]
    lines += ["| key | value | default |", "|---|---|---|"]
    for key, field in model.model_fields.items():
        lines.append(f"| `{key}` | {_value(field)} | {_default(field)} |")
    return "\n".join(lines) + "\n"


def _title(model: type[BaseModel]) -> str:
    kind = model.model_fields.get("kind")
    chosen = get_args(kind.annotation) if kind is not None else ()
    if len(chosen) == 1:
        group = "contact" if model in _mentioned(schema.ContactSpec) else "task"
        return f"{group} of kind `{chosen[0]}`"
    return f"`{model.__name__}`"


def _value(field: FieldInfo) -> str:
    bounds = _bounds(field.metadata)
    return _words(field.annotation) + (f" {bounds}" if bounds else "")


def _words(annotation: Any) -> str:
    """Return a type in words."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        inner, *metadata = arguments
        bounds = _bounds([m for data in metadata for m in _constraints(data)])
        return _words(inner) + (f" {bounds}" if bounds else "")
    if origin in (Union, UnionType):
        return " or ".join(_words(a) for a in arguments if a is not NoneType)
    if origin is Literal:
        return ", ".join(f"`{_yaml(a)}`" for a in arguments)
    if origin is list:
        return f"list of {_words(arguments[0])}"
    if origin is dict:
        return f"mapping of names to {_words(arguments[1])}"
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        return f"[{_title(annotation)}](#{_anchor(annotation)})"
    plain = {float: "number", int: "integer", str: "text", bool: "true or false"}
    return plain.get(annotation, str(annotation))


def _constraints(data: Any) -> list[Any]:
    return list(data.metadata) if isinstance(data, FieldInfo) else [data]


def _bounds(metadata: list[Any]) -> str:
    words = []
    for item in metadata:
        words += [f"{sign} {getattr(item, b):g}" for b, sign in BOUNDS.items() if hasattr(item, b)]
    words = [", ".join(words)] if words else []
    lengths = {
        name: getattr(item, name)
        for item in metadata
        for name in ("min_length", "max_length")
        if hasattr(item, name)
    }
    if "max_length" in lengths and lengths.get("min_length") == lengths["max_length"]:
        words.append(f"({lengths['max_length']} of them)")
    elif lengths.get("min_length"):
        words.append("(at least one)")
    return " ".join(words)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if isinstance(value, BaseModel):
        given = value.model_dump(exclude_unset=True, mode="json")
        return f"`{_yaml(given)}`" if given else "its defaults"
    return "none" if value is None else f"`{_yaml(value)}`"


def _yaml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k}: {_yaml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_yaml, value)) + "]"
    return '""' if value == "" else f"{value}"


def _anchor(model: type[BaseModel]) -> str:
    text = _title(model).replace("`", "").lower()
    return "".join(c for c in text if c.isalnum() or c in " -_").replace(" ", "-")


def _metrics() -> str:
    bar = r"\|"
    lines = ["## Metrics\n", "What `acceptance.limits` may bound, and what `summary.json` holds:\n"]
    lines += ["| metric | unit | what it is |", "|---|---|---|"]
    lines += [f"| `{m.name}` | {m.unit} | {m.doc.replace('|', bar)} |" for m in METRICS.values()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(f"{TARGET}: {'written' if write_tables() else 'is current'}")
