"""Files of gains: values of a scenario's `control` section, found once and used often."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from equipoise.errors import ScenarioError
from equipoise.scenarios.text_files import text_of_file
from equipoise.scenarios.yaml_tree import load_tree, plain_tree

SECTION = "control"


def read_gains(path: Path | str) -> dict[str, Any]:
    """Return what a file of gains sets: values by their path in a scenario, all under `control`.

    Raises: `ScenarioError`.
    """
    path = Path(path)
    tree = plain_tree(load_tree(text_of_file(path, "gains"), str(path), "file of gains"))
    values = tree.get("set")
    if not isinstance(values, dict) or not values or set(tree) - {"set", "about"}:
        raise ScenarioError(
            f"{path}: wanted the key 'set', a mapping from paths to values, and nothing else "
            "but 'about'",
            given=sorted(tree),
            remedy="For example  set: {control.gains.alpha: 10.0}",
        )
    for name in values:
        if not name.startswith(f"{SECTION}."):
            raise ScenarioError(
                f"{path}: gains belong to the section {SECTION}",
                given=name,
                remedy="Change anything else with --set, or in the scenario",
            )
    return values


def gains_overrides(path: Path | str) -> list[str]:
    """Return what a file of gains sets as overrides `path=value`. Raises: `ScenarioError`."""
    return [f"{name}={json.dumps(value)}" for name, value in read_gains(path).items()]


def gains_text(values: Mapping[str, Any], about: Sequence[str]) -> str:
    """Return the text of a file of gains; `about` says in sentences where they come from."""
    lines = ["# A file of gains: equipoise run SCENARIO --gains THIS_FILE", "about:"]
    lines += [f"  - {json.dumps(sentence, ensure_ascii=False)}" for sentence in about]
    lines += ["set:", *(f"  {name}: {json.dumps(value)}" for name, value in values.items())]
    return "\n".join(lines) + "\n"
