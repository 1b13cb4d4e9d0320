"""Broken copies of the HRP-2 description are refused kindly or give a sound robot; never worse."""

from __future__ import annotations

import random
import re
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from equipoise.errors import InputError
from equipoise.robots import check_urdf, load_robot, robot_urdf_path
from equipoise.robots.files.finding import ERROR

URDF = robot_urdf_path("hrp2")
BAD_NUMBERS = (
    "nan", "inf", "-inf", "1e400", "-1e400", "1e308", "1e13", "1e11", "-1", "0", "-0.0", "1e-320",
    "1e-30", "", "abc", "0x10", "1,5", "1_0", "١", "1 2", "NaN(1)", "+", "1e", "--1", "9" * 400,
)  # fmt: skip
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?(?=[ \"])")
ATTRIBUTE = re.compile(r' (\w+)="([^"]*)"')
TAG = re.compile(r"<(/?)(\w+)[^>]*>")


def replaced(text: str, match: re.Match, new: str) -> str:
    return text[: match.start()] + new + text[match.end() :]


def change_number(text: str, rng: random.Random) -> str:
    match = rng.choice(list(NUMBER.finditer(text)))
    scaled = repr(float(match[0]) * rng.choice((-1, 10, 1e3, 1e6, 1e9, 1e-3, 1e-9)))
    return replaced(text, match, rng.choice((*BAD_NUMBERS, scaled)))


def remove_attribute(text: str, rng: random.Random) -> str:
    return replaced(text, rng.choice(list(ATTRIBUTE.finditer(text))), "")


def swap_attributes(text: str, rng: random.Random) -> str:
    first, second = sorted(rng.sample(list(ATTRIBUTE.finditer(text)), 2), key=lambda m: m.start())
    text = replaced(text, second, f' {second[1]}="{first[2]}"')
    return replaced(text, first, f' {first[1]}="{second[2]}"')


def remove_tag(text: str, rng: random.Random) -> str:
    return replaced(text, rng.choice(list(TAG.finditer(text))), "")


def rename_tag(text: str, rng: random.Random) -> str:
    match = rng.choice(list(TAG.finditer(text)))
    return replaced(text, match, match[0].replace(match[2], rng.choice(("x", "link", "joint")), 1))


def remove_element(text: str, rng: random.Random) -> str:
    elements = list(re.finditer(r"<(\w+)[^>]*/>|<(inertial|link|joint)\b.*?</\2>", text, re.S))
    return replaced(text, rng.choice(elements), "")


def double_element(text: str, rng: random.Random) -> str:
    elements = list(re.finditer(r"<(\w+)[^>]*/>|<(inertial|link|joint)\b.*?</\2>", text, re.S))
    match = rng.choice(elements)
    return replaced(text, match, match[0] * 2)


def change_type(text: str, rng: random.Random) -> str:
    match = rng.choice(list(re.finditer(r'type="\w+"', text)))
    kinds = ("fixed", "continuous", "floating", "planar", "prismatic", "spherical", "")
    return replaced(text, match, f'type="{rng.choice(kinds)}"')


def change_name(text: str, rng: random.Random) -> str:
    names = [m for m in ATTRIBUTE.finditer(text) if m[1] in ("name", "link")]
    match = rng.choice(names)
    new = rng.choice((rng.choice(names)[2], "", "universe", "root_joint", "a b", "é", "x" * 300))
    return replaced(text, match, f' {match[1]}="{new}"')


def cut(text: str, rng: random.Random) -> str:
    return text[: rng.randrange(len(text))]


def change_character(text: str, rng: random.Random) -> str:
    place = rng.randrange(len(text))
    return text[:place] + rng.choice("<>&\"'/=\x00\x01 9-") + text[place + 1 :]


def change_word(text: str, rng: random.Random) -> str:
    words = list(re.finditer(r"[\w.-]+", text))
    return replaced(text, rng.choice(words), rng.choice((*BAD_NUMBERS, rng.choice(words)[0])))


MUTATIONS = (
    change_number, change_number, change_number, change_number, remove_attribute, swap_attributes,
    remove_tag, rename_tag, remove_element, double_element, change_type, change_name, cut,
    change_character,
)  # fmt: skip


def mutated(seed: int) -> str:
    rng = random.Random(seed)
    text = URDF.read_text(encoding="utf-8")
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        text = rng.choice(MUTATIONS)(text, rng) if len(text) > 20_000 else text
    return text


def outcome(path: Path) -> str:
    """Return "refused" or "loaded"; fail on an unsound robot."""
    errors = [finding for finding in check_urdf(path) if finding.severity == ERROR]
    try:
        robot = load_robot(path)
    except InputError as error:
        said = str(error)
        robot = None
    if robot is None:
        assert errors
        assert len(said) > 20
        return "refused"
    assert not errors
    matrix = pin.crba(robot.model, robot.model.createData(), robot.q_half_sitting)
    matrix = np.triu(matrix) + np.triu(matrix, 1).T
    assert np.isfinite(matrix).all()
    scale = np.sqrt(np.diag(matrix))
    np.linalg.cholesky(matrix / np.outer(scale, scale))
    assert np.isfinite([robot.q_min, robot.q_max, robot.v_max, robot.tau_max]).all()
    assert (robot.q_min < robot.q_max).all()
    assert min(*robot.v_max, *robot.tau_max) > 0.0
    return "loaded"


@pytest.mark.parametrize("block", range(4))
def test_mutated_descriptions_are_refused_or_sound(block: int, tmp_path: Path) -> None:
    path = tmp_path / "broken.urdf"
    for suffix in (".srdf", ".yaml"):
        shutil.copyfile(URDF.with_suffix(suffix), path.with_suffix(suffix))
    outcomes = []
    for seed in range(40 * block, 40 * block + 40):
        path.write_bytes(mutated(seed).encode())
        outcomes.append(outcome(path))
    # Both happen: the test neither refuses everything nor mutates nothing of weight.
    assert outcomes.count("refused") > 5
    assert outcomes.count("loaded") > 0


@pytest.mark.parametrize("suffix", [".srdf", ".yaml"])
def test_mutated_companions_are_refused_or_sound(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / "hrp2.urdf"
    for kind in (".urdf", ".srdf", ".yaml"):
        shutil.copyfile(URDF.with_suffix(kind), path.with_suffix(kind))
    text = URDF.with_suffix(suffix).read_text(encoding="utf-8")
    outcomes = []
    for seed in range(30):
        rng = random.Random(seed)
        broken = rng.choice((cut, change_character, change_word))(text, rng)
        path.with_suffix(suffix).write_bytes(broken.encode())
        outcomes.append(outcome(path))
    assert {"refused", "loaded"} == set(outcomes)
