"""YAML of strangers is read within bounds, and what is wrong with it is said in a line."""

from __future__ import annotations

import time
from itertools import pairwise

import pytest

from equipoise.bounded_yaml import MOST_DEPTH, MOST_NODES, BadYamlError, load_yaml
from equipoise.errors import InputError, ScenarioError
from equipoise.robots.files.extras import read_extras
from equipoise.scenarios.read import parse_scenario


def bomb(letters: str = "abcdefgh", width: int = 10) -> str:
    """Return lists that repeat one another: `width` to the power of their number of entries."""
    lines = [f"a: &a [{','.join('x' * width)}]"]
    for before, letter in pairwise(letters):
        lines.append(f"{letter}: &{letter} [{','.join([f'*{before}'] * width)}]")
    return "\n".join(lines) + "\n"


TOO_MUCH = {
    "alias bomb": bomb(),
    "narrow alias bomb": bomb("abcdefghijklmnopqrst", 2),
    "bomb of mappings": bomb().replace("[", "{k: [").replace("]", "]}"),
    "merged bomb": "b0: &b0 {x: 1}\n"
    + "".join(f"b{i}: &b{i} {{<<: *b{i - 1}, y{i}: *b0}}\n" for i in range(1, 9))
    + "c: [" + ", ".join(["*b8"] * 3000) + "]",
    "deep flow": "x: " + "{a: " * 300 + "1" + "}" * 300,
    "deep lists": "x: " + "[" * 5000 + "]" * 5000,
    "deep block": "\n".join("  " * i + "a:" for i in range(MOST_DEPTH + 5)),
    "many": "x: [" + "1," * (MOST_NODES + 5) + "]",
    "itself": "a: &a [*a]",
    "itself, deeper": "a: &a {b: [1, {c: *a}]}",
    "long": "# " + "x" * 1_100_000,
    "huge number": "a: " + "9" * 5000,
}  # fmt: skip
NOT_YAML = {
    "no end": "a: 'x",
    "no alias": "a: *b",
    "key twice": "a: 1\na: 2",
    "bad date": "a: 2001-99-99",
    "bad tag": "a: !!int 'x'",
    "bad merge": "<<: 3",
    "control": "a: \x00",
    "two documents": "---\na: 1\n---\nb: 2",
    "quoted for long": "a: " + "'" + "b" * 100_000,
}


@pytest.mark.parametrize("case", [*TOO_MUCH, *NOT_YAML])
def test_refused_at_once_and_in_a_line(case, tmp_path):
    text = {**TOO_MUCH, **NOT_YAML}[case]
    begun = time.process_time()
    with pytest.raises(BadYamlError) as caught:
        load_yaml(text)
    assert len(str(caught.value)) < 300
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(text, source="x.yaml")
    assert len(str(caught.value)) < 600
    path = tmp_path / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_extras(path)
    assert len(str(caught.value)) < 600
    assert time.process_time() - begun < 20.0


def test_the_case_of_a_bomb_below_the_bound_is_read():
    tree = load_yaml(bomb("abc"))
    assert sum(len(x) for row in tree["c"] for x in row) == 1000
    assert load_yaml("a: &x {k: 1}\nb: {<<: *x, j: 2}")["b"]["k"] == 1


def test_aliases_count_as_what_they_repeat():
    """Ten times 1,999 entries and their lists are just within the bound; eleven times are not."""
    line = "a: &a [" + ",".join(["1"] * 1999) + "]\n"
    load_yaml(line + "b: [" + ",".join(["*a"] * 8) + "]")
    with pytest.raises(BadYamlError, match="aliases repeat"):
        load_yaml(line + "b: [" + ",".join(["*a"] * 10) + "]")


def test_what_was_given_is_quoted_in_a_line_at_most():
    for text in (
        f"title: [{','.join(['7'] * 3000)}]\nname: x\nduration: 1",
        "x" * 3000 + ": 1",
        "name: x\nduration: 1\ncontacts: {" + "y" * 3000 + ": 1}",
        "name: x\nduration: 1\ntitle: '" + "z" * 3000 + "'",
        'name: "x\\ny"\nduration: 1\ntitle: "a\\nb"',
    ):
        with pytest.raises(ScenarioError) as caught:
            parse_scenario(text, source="x.yaml")
        message = str(caught.value)
        assert len(message) < 900, message
        assert "\n" not in message
    assert len(str(InputError("problem", given=list(range(100_000))))) < 250
    assert len(str(InputError("problem", given="x" * 100_000))) < 250
