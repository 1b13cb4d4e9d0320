"""YAML 1.2 text as a tree of plain values; duplicate keys are refused, lines are remembered."""

from __future__ import annotations

from typing import Any

from equipoise.bounded_yaml import BadYamlError, load_yaml
from equipoise.errors import ScenarioError


def load_tree(text: str, source: str, kind: str = "scenario") -> Any:
    """Return ruamel's tree, which knows the line of each key; `plain_tree` makes it a plain one.

    Raises: `ScenarioError` if it is not YAML, too long, too deep or no mapping.
    """
    try:
        tree = load_yaml(text)
    except BadYamlError as error:
        raise ScenarioError(
            error.problem, path=source, line=error.line, remedy=error.remedy
        ) from error
    if not isinstance(tree, dict):
        raise ScenarioError(f"a {kind} is a mapping of keys to values", path=source)
    return tree


def load_value(text: str, path: str) -> Any:
    """Return the plain value that `text` stands for. Raises: `ScenarioError` with the path."""
    try:
        return plain_tree(load_yaml(text))
    except BadYamlError as error:
        raise ScenarioError(
            f"the value is not valid YAML ({error.problem})",
            path=path,
            given=text,
            remedy=error.remedy,
        ) from error


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


def merged(base: Any, changes: Any) -> Any:
    """Return `base` with `changes` written over it, mapping by mapping."""
    if not (isinstance(base, dict) and isinstance(changes, dict)):
        return changes
    both = dict(base)
    for key, value in changes.items():
        both[key] = merged(base.get(key), value)
    return both
