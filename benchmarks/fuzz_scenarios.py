"""Mutated scenarios: each is refused kindly, or is built and runs its first ticks; never worse.

`python benchmarks/fuzz_scenarios.py --count 1500 [--seed 0] [--limit 60]`

A shipped scenario is changed in one to four places: numbers, keys, kinds, names, entries taken out,
doubled or exchanged, the text itself, or by an override as of `--set`. What is not refused is put
together and run for some ticks, with the engine that the file names. Ends with 1 if a case raised
anything but an error of ours, took too long, killed its process, was said in more than a line, or
gave a torque that is not finite or above its limit.
"""

from __future__ import annotations

import copy
import random
import sys
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from fuzz_urdf import assert_readable, change_character, change_word, cut
from fuzzing import main

from equipoise.bounded_yaml import load_yaml
from equipoise.errors import EquipoiseError, InputError
from equipoise.scenarios import named_scenarios
from equipoise.scenarios.read import parse_scenario
from equipoise.scenarios.yaml_tree import plain_tree
from equipoise.simulation.simulation import Simulation

TICKS = 4
VALUES = (
    None, True, False, 0, 1, -1, 3, 0.0, -0.0, 1e-9, -1e-3, 0.5, 1e3, 1e9, 1e308, float("nan"),
    float("inf"), 10**30, "", "x", "base", "floor", "world", "universe", "left_sole", "right_palm",
    "a" * 300, "<b>", "${x}", "é", [], {}, [1], [0, 0, 0], [1, 0, 0], {"a": 1}, "nan", "1",
    "BODY", "tray", "hrp2", "mujoco", "rigid",
)  # fmt: skip


def places(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the paths of all entries of a tree."""
    found: list[tuple[Any, ...]] = []
    items = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


def at(tree: Any, path: tuple[Any, ...]) -> Any:
    """Return the entry at a path."""
    for step in path:
        tree = tree[step]
    return tree


def changed_value(value: Any, rng: random.Random) -> Any:
    """Return another value: mostly a number that is scaled, else anything."""
    if isinstance(value, int | float) and not isinstance(value, bool) and rng.random() < 0.7:
        gentle = (0.5, 0.8, 0.9, 0.95, 1.05, 1.1, 1.3, 2.0)
        scale = rng.choice((*gentle, -1.0, 0.0, 10.0, 1e3, 1e6, 1e-3, 1e-9))
        return type(value)(value * scale) if rng.random() < 0.7 else value * scale
    return copy.deepcopy(rng.choice(VALUES))


def mutate(tree: Any, rng: random.Random) -> None:
    """Change one entry of a tree in place."""
    known = places(tree)
    if not known:
        return
    path = rng.choice(known)
    home, last = at(tree, path[:-1]), path[-1]
    what = rng.random()
    if what < 0.75:
        home[last] = changed_value(home[last], rng)
    elif what < 0.82:
        del home[last]
    elif what < 0.87 and isinstance(home, dict):
        names = ("x", "", last.upper(), "base", "floor", "world", "a b", "1", *map(str, home))
        home[rng.choice(names)] = home.pop(last)
    elif what < 0.94:
        home[last] = copy.deepcopy(at(tree, rng.choice(known)))
    elif isinstance(home, list):
        home.insert(last, copy.deepcopy(home[last]))
    else:
        home[f"{last}2"] = copy.deepcopy(home[last])


def written(tree: Any) -> str:
    """Return a tree as YAML, in its flow style, as it stands."""
    if isinstance(tree, dict):
        return "{" + ", ".join(f"{written(str(k))}: {written(v)}" for k, v in tree.items()) + "}"
    if isinstance(tree, list):
        return "[" + ", ".join(map(written, tree)) + "]"
    if isinstance(tree, bool) or tree is None:
        return {True: "true", False: "false", None: "null"}[tree]
    if isinstance(tree, float):
        return {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}.get(repr(tree), repr(tree))
    if isinstance(tree, int):
        return str(tree)
    return '"' + str(tree).replace("\\", "\\\\").replace('"', '\\"') + '"'


def case_of(seed: int) -> tuple[str, list[str]]:
    """Return the text of a mutated scenario, and overrides."""
    rng = random.Random(seed)
    path = rng.choice(sorted(named_scenarios().values()))
    text, overrides = path.read_text(encoding="utf-8"), []
    kind = rng.random()
    if kind < 0.15:
        for _ in range(rng.choice((1, 1, 2))):
            text = rng.choice((change_character, change_word, change_word, cut))(text, rng)
        return text, overrides
    tree = plain_tree(load_yaml(text))
    if kind < 0.25:
        steps = rng.choice(places(tree))
        value = changed_value(at(tree, steps), rng)
        path_text = ".".join(map(str, steps))
        path_text = rng.choice(
            (path_text, path_text, path_text + ".x", change_word(path_text, rng))
        )
        return text, [f"{path_text}={written(value)}"]
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        mutate(tree, rng)
    return written(tree), overrides


def outcome(seed: int, folder: Path) -> str:
    """Return "refused", "not built", "stopped" or "ran". Raises: what is not an error of ours."""
    text, overrides = case_of(seed)
    texts = {name: path.read_text(encoding="utf-8") for name, path in named_scenarios().items()}

    def text_of(name: str) -> str:
        if name not in texts:
            raise InputError("there is no such scenario", given=name, known=texts)
        return texts[name]

    try:
        scenario = parse_scenario(text, overrides, source="mutated.yaml", text_of=text_of)
    except InputError as error:
        assert_readable(str(error))
        return "refused"
    try:
        simulation = Simulation(scenario)
    except EquipoiseError as error:
        assert_readable(str(error))
        return "not built"
    limits = simulation.robot.tau_max * (1.0 + 1e-9)
    try:
        for _, record in islice(simulation.ticks(), TICKS):
            tau = record["tau"]
            assert np.isfinite(tau).all(), "a torque is not finite"
            assert (np.abs(tau) <= limits).all(), "a torque is above its limit"
    except EquipoiseError as error:
        assert_readable(str(error))
        return "stopped"
    return "ran"


if __name__ == "__main__":
    sys.exit(main(outcome, "mutated scenarios"))
