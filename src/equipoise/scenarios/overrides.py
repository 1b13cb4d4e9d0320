"""Overrides `path=value`: one value of a scenario changed from the command line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.scenarios.yaml_tree import load_value

DEEPEST = 30  # steps of a path
# Sections whose names the scenario itself makes: a key of what does not exist is a slip of the pen.
NAMED = {
    "contacts": "contact",
    "tasks": "task",
    "world.bodies": "fixed body",
    "world.objects": "object",
    "world.sliders": "slider",
}


def override_of(path: str, overrides: Sequence[str]) -> str | None:
    """Return the last override that wrote the value at `path`, or a part or the whole of it."""
    for override in reversed(overrides):
        written = override.partition("=")[0].strip()
        if path and (f"{path}.".startswith(f"{written}.") or f"{written}.".startswith(f"{path}.")):
            return override
    return None


def apply_overrides(tree: dict[str, Any], overrides: Sequence[str]) -> None:
    """Write each `a.b.c=value` into the nested mappings of `tree`; list items go by number.

    A new contact, task, body, object or slider is given whole, as a mapping.
    Raises: `ScenarioError` if a step of a path does not lead on.
    """
    for override in overrides:
        path, separator, value = override.partition("=")
        if not separator or not path.strip():
            raise ScenarioError(
                "an override has the form path=value",
                given=override,
                remedy="For example --set control.gains.alpha=10",
            )
        write_value(tree, path.strip(), load_value(value, path))


def write_value(tree: Any, path: str, value: Any) -> None:
    """Write one value into nested mappings and lists. Raises: as `apply_overrides`."""
    *parents, last = path.split(".")
    if len(parents) > DEEPEST:
        raise ScenarioError(f"a path of more than {DEEPEST} steps", path=path)
    node = tree
    for i, step in enumerate(parents):
        node = _descend(node, step, ".".join(parents[: i + 1]))
    if isinstance(node, list):
        node[_index(node, last, path)] = value
    elif isinstance(node, dict):
        node[last] = value
    else:
        raise ScenarioError("the path leads into a plain value", path=path)


def _descend(node: Any, step: str, path: str) -> Any:
    if isinstance(node, list):
        return node[_index(node, step, path)]
    if isinstance(node, dict):
        section = path.rpartition(".")[0]
        if step not in node and section in NAMED:
            raise _nothing_of_that_name(NAMED[section], step, path, node)
        return node.setdefault(step, {})
    raise ScenarioError("the path leads into a plain value", path=path)


def _nothing_of_that_name(kind: str, name: str, path: str, known: dict[str, Any]) -> ScenarioError:
    whole = f"A new {kind} is given whole: --set '{path}={{...}}'"
    error = NameNotFoundError(kind, name, known, remedy=whole)
    return ScenarioError(error.problem, path=path, known=error.known, remedy=error.remedy)


def _index(items: list[Any], step: str, path: str) -> int:
    if not (step.isascii() and step.isdecimal() and len(step) < 10) or int(step) >= len(items):
        raise ScenarioError(
            "no such item of the list", path=path, given=step, remedy=f"It has {len(items)} items"
        )
    return int(step)
