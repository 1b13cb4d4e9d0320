"""Reading scenario text: what it extends, its overrides, errors with line and path."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from ruamel.yaml import YAML

from equipoise.errors import NameNotFoundError, ScenarioError, quoted
from equipoise.scenarios.overrides import apply_overrides, override_of
from equipoise.scenarios.schema import Scenario
from equipoise.scenarios.yaml_tree import load_tree, plain_tree


def parse_scenario(
    text: str,
    overrides: Sequence[str] = (),
    *,
    source: str = "",
    text_of: Callable[[str], str] | None = None,
    robot: str | None = None,
) -> Scenario:
    """Return the scenario that `text` describes, with `path=value` overrides applied.

    A file that begins with `extends: NAME` states only what differs from another scenario, whose
    text `text_of(NAME)` gives. For another `robot` than the file's, what the file says under
    `for_robot` of that name is written over it, then everything is retargeted.
    Raises: `ScenarioError` naming the line or path, what was given and what is known.
    """
    tree = load_tree(text, source)
    plain = plain_tree(tree)
    base = plain.pop("extends", None)
    if base is not None:
        if text_of is None or not isinstance(base, str):
            raise ScenarioError(
                "only a scenario read by name or file can extend another", path="extends"
            )
        plain = _merged(plain_tree(load_tree(text_of(base), base)), plain)
    exceptions = plain.pop("for_robot", {})
    if robot is not None and robot != plain.get("robot", Scenario.model_fields["robot"].default):
        from equipoise.scenarios.retarget import retarget

        plain = retarget(_validated(_merged(plain, _exception(exceptions, robot)), tree), robot)
    apply_overrides(plain, overrides)
    try:
        return _validated(plain, tree)
    except ScenarioError as error:
        raise placed(error, overrides, source) from None


def _validated(plain: dict[str, Any], tree: Any) -> Scenario:
    try:
        return Scenario.model_validate(plain)
    except ValidationError as error:
        raise _translate(error, plain, tree) from None


def placed(error: ScenarioError, overrides: Sequence[str], source: str = "") -> ScenarioError:
    """Return the same complaint with where its value comes from: an override, or a file."""
    override = override_of(error.path, overrides)
    if override is not None:
        return error.at(f"--set {override}")
    named = source.endswith((".yaml", ".yml"))
    return error.at(source, line=error.line) if named else error


def line_of(text: str, path: str) -> int | None:
    """Return the line (from 1) of the deepest part of a path `a.b.c` that a scenario's text has."""
    steps: list[Any] = [int(step) if step.isdigit() else step for step in path.split(".")]
    return _line(load_tree(text, ""), steps)


def _exception(exceptions: Any, robot: str) -> dict[str, Any]:
    """Return what a scenario says of one robot alone."""
    if not isinstance(exceptions, dict) or not all(
        isinstance(changes, dict) for changes in exceptions.values()
    ):
        raise ScenarioError(
            "wanted a mapping from robots to what is different on them", path="for_robot"
        )
    return exceptions.get(robot, {})


def resolved_text(scenario: Scenario) -> str:
    """Return the scenario as YAML with every default written out; it parses back to itself."""
    yaml = YAML(typ="safe")
    yaml.default_flow_style = None
    yaml.width = 100
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]  # declared as None
    stream = io.StringIO()
    yaml.dump(scenario.model_dump(mode="json", exclude_none=True), stream)
    return stream.getvalue()


def _merged(base: Any, changes: Any) -> Any:
    """Return `base` with `changes` written over it, mapping by mapping."""
    if not (isinstance(base, dict) and isinstance(changes, dict)):
        return changes
    merged = dict(base)
    for key, value in changes.items():
        merged[key] = _merged(base.get(key), value)
    return merged


def _translate(error: ValidationError, plain: Any, tree: Any) -> ScenarioError:
    """Return our error for one complaint of pydantic; an unknown key explains a missing one."""
    complaints = error.errors(include_url=False)
    first = min(complaints, key=lambda c: c["type"] != "extra_forbidden")
    told: Any = (first.get("ctx") or {}).get("at")  # where a check of the whole scenario found it
    location = list(told) if told else _without_tags(first["loc"], plain)
    path = ".".join(str(part) for part in location)
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "extra_forbidden":
        known = _known_keys(location[:-1], plain)
        hint = NameNotFoundError("key", str(location[-1]), known)
        return ScenarioError(
            f"unknown key {quoted(location[-1])}",
            path=path,
            line=_line(tree, location),
            known=known,
            remedy=hint.remedy,
        )
    if first["type"] == "missing":
        return ScenarioError(
            f"key {quoted(location[-1])} is missing", path=path, line=_line(tree, location[:-1])
        )
    line = _line(tree, location)
    if first["type"] == "union_tag_not_found":
        return ScenarioError("key 'kind' is missing", path=path, line=line, known=_kinds(location))
    given: Any = None if told else first.get("input")
    if first["type"] == "union_tag_invalid":
        hint = NameNotFoundError("kind", str(given["kind"]), _kinds(location))
        return ScenarioError(
            hint.problem, path=path, line=line, known=hint.known, remedy=hint.remedy
        )
    if first["type"] in ("model_type", "dict_type", "model_attributes_type"):
        message, known = "a mapping of keys is wanted", _known_keys(location, plain)
        return ScenarioError(message, path=path, line=line, given=given, known=known)
    if isinstance(given, dict | list | BaseModel) and len(str(given)) > 80:
        given = None
    return ScenarioError(message, path=path, line=line, given=given)


def _kinds(location: list[Any]) -> list[str]:
    """Return the kinds of the scenario's contacts or tasks, wherever `location` lies."""
    section = Scenario.model_fields[str(location[0])].annotation
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


def _known_keys(location: list[Any], plain: Any) -> list[str]:
    """Return the keys that the section at `location` may have."""
    model: Any = Scenario
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


def _line(tree: Any, location: list[Any]) -> int | None:
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
