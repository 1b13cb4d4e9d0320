"""Reading scenario text: what it extends, its overrides, errors with line and path."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML

from equipoise.errors import ScenarioError
from equipoise.scenarios.complaints import complaint, line_in
from equipoise.scenarios.overrides import apply_overrides, override_of
from equipoise.scenarios.schema import Scenario
from equipoise.scenarios.yaml_tree import load_tree, merged, plain_tree


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
        plain = merged(plain_tree(load_tree(text_of(base), base)), plain)
    exceptions = plain.pop("for_robot", {})
    if robot is not None and robot != plain.get("robot", Scenario.model_fields["robot"].default):
        from equipoise.scenarios.retarget import retarget

        plain = retarget(_validated(merged(plain, _exception(exceptions, robot)), tree), robot)
    apply_overrides(plain, overrides)
    try:
        return _validated(plain, tree)
    except ScenarioError as error:
        raise placed(error, overrides, source) from None


def _validated(plain: dict[str, Any], tree: Any) -> Scenario:
    try:
        return Scenario.model_validate(plain)
    except ValidationError as error:
        raise complaint(error, plain, tree, Scenario) from None


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
    return line_in(load_tree(text, ""), steps)


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
