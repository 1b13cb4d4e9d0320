"""YAML 1.2 text as a tree of plain values; duplicate keys are refused, lines are remembered."""

from __future__ import annotations

from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from equipoise.errors import ScenarioError

_SIZE_MAX = 1_000_000


def load_tree(text: str, source: str) -> Any:
    """Return ruamel's tree, which knows the line of each key; `plain_tree` makes it a plain one.

    Raises: `ScenarioError` if it is not YAML, too long, or no mapping.
    """
    if len(text) > _SIZE_MAX:
        raise ScenarioError(f"{source or 'the scenario'} is longer than {_SIZE_MAX} characters")
    try:
        tree = YAML(typ="rt", pure=True).load(text)
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None) or str(error)
        line = mark.line + 1 if mark is not None else None
        raise ScenarioError(f"not valid YAML: {problem}", path=source, line=line) from None
    if not isinstance(tree, dict):
        raise ScenarioError("a scenario is a mapping of keys to values", path=source)
    return tree


def load_value(text: str, path: str) -> Any:
    """Return the plain value that `text` stands for. Raises: `ScenarioError` with the path."""
    try:
        return plain_tree(YAML(typ="rt", pure=True).load(text))
    except YAMLError:
        raise ScenarioError("the value is not valid YAML", path=path, given=text) from None


def plain_tree(node: Any) -> Any:
    """Return ruamel's tree as plain dicts, lists, str, int, float, bool."""
    if isinstance(node, dict):
        return {str(key): plain_tree(value) for key, value in node.items()}
    if isinstance(node, list):
        return [plain_tree(value) for value in node]
    if isinstance(node, bool) or node is None:
        return node
    for kind in (int, float, str):
        if isinstance(node, kind):
            return kind(node)
    return str(node)
