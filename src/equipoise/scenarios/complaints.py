"""What pydantic complains of, said as our errors: path, line, what was given and what is known."""

from __future__ import annotations

from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from equipoise.errors import NameNotFoundError, ScenarioError, quoted


def complaint(
    error: ValidationError, plain: Any, tree: Any, model: type[BaseModel]
) -> ScenarioError:
    """Return our error for one complaint of pydantic; an unknown key explains a missing one.

    `plain` is what did not fit `model`, `tree` the same as ruamel read it, which knows the lines.
    """
    complaints = error.errors(include_url=False)
    first = min(complaints, key=lambda c: c["type"] != "extra_forbidden")
    told: Any = (first.get("ctx") or {}).get("at")  # where a check of the whole scenario found it
    location = list(told) if told else _without_tags(first["loc"], plain)
    path = ".".join(str(part) for part in location)
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "extra_forbidden":
        known = _known_keys(location[:-1], plain, model)
        hint = NameNotFoundError("key", str(location[-1]), known)
        return ScenarioError(
            f"unknown key {quoted(location[-1])}",
            path=path,
            line=line_in(tree, location),
            known=known,
            remedy=hint.remedy,
        )
    if first["type"] == "missing":
        return ScenarioError(
            f"key {quoted(location[-1])} is missing", path=path, line=line_in(tree, location[:-1])
        )
    line = line_in(tree, location)
    if first["type"] == "union_tag_not_found":
        return ScenarioError(
            "key 'kind' is missing", path=path, line=line, known=_kinds(location, model)
        )
    given: Any = None if told else first.get("input")
    if first["type"] == "union_tag_invalid":
        hint = NameNotFoundError("kind", str(given["kind"]), _kinds(location, model))
        return ScenarioError(
            hint.problem, path=path, line=line, known=hint.known, remedy=hint.remedy
        )
    if first["type"] in ("model_type", "dict_type", "model_attributes_type"):
        message, known = "a mapping of keys is wanted", _known_keys(location, plain, model)
        return ScenarioError(message, path=path, line=line, given=given, known=known)
    if isinstance(given, dict | list | BaseModel) and len(str(given)) > 80:
        given = None
    return ScenarioError(message, path=path, line=line, given=given)


def _kinds(location: list[Any], model: type[BaseModel]) -> list[str]:
    """Return the kinds that what stands in a section may have, wherever `location` lies in it."""
    section = model.model_fields[str(location[0])].annotation
    models = _members(get_args(section)[-1])
    return [kind for m in models for kind in get_args(m.model_fields["kind"].annotation)]


def _without_tags(given: tuple[Any, ...], plain: Any) -> list[Any]:
    """Return the location in the file: pydantic also names the `kind` it chose, which is no key."""
    location: list[Any] = []
    node, tagged = plain, False
    for part in given:
        if isinstance(node, dict) and part == node.get("kind") and not tagged:
            tagged = True  # a key may be called like the kind: it then comes after it
            continue
        location.append(part)
        node, tagged = _step(node, part), False
    return location


def _known_keys(location: list[Any], plain: Any, root: type[BaseModel]) -> list[str]:
    """Return the keys that the section at `location` may have."""
    model: Any = root
    node = plain
    for part in location:
        node = _step(node, part)
        model = _next_model(model, part, node)
        if model is None:
            return []
    return list(model.model_fields) if hasattr(model, "model_fields") else []


def _next_model(model: Any, part: Any, node: Any) -> Any:
    annotation: Any = model
    if isinstance(model, type) and issubclass(model, BaseModel):
        field = model.model_fields.get(str(part))
        if field is None:
            return None
        annotation = field.annotation
    else:
        annotation = get_args(model)[-1] if get_args(model) else None
    return _resolve(annotation, node)


def _resolve(annotation: Any, node: Any) -> Any:
    """Return the model behind an annotation: the member of a union that `node` chose, if any."""
    models = [m for m in _members(annotation) if isinstance(m, type) and issubclass(m, BaseModel)]
    if len(models) > 1 and isinstance(node, dict):
        for m in models:
            kinds = get_args(m.model_fields["kind"].annotation) if "kind" in m.model_fields else ()
            if node.get("kind") in kinds:
                return m
    return models[0] if len(models) == 1 else annotation


def _members(annotation: Any) -> list[Any]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    origin_is_container = getattr(annotation, "__origin__", None) in (dict, list)
    if origin_is_container:
        return []
    return [m for argument in get_args(annotation) for m in _members(argument)]


def _step(node: Any, part: Any) -> Any:
    try:
        return node[part]
    except (KeyError, IndexError, TypeError):
        return None


def line_in(tree: Any, location: list[Any]) -> int | None:
    """Return the line (from 1) of the deepest part of `location` that the file has."""
    node, line = tree, None
    for part in location:
        positions = getattr(getattr(node, "lc", None), "data", None) or {}
        if part in positions:
            line = positions[part][0] + 1
        node = _step(node, part)
        if node is None:
            break
    return line
