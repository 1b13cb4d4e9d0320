"""A scenario told for another robot: similar figures, links of the same parts, the same file."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from equipoise.errors import ScenarioError
from equipoise.robots import get_robot, named_robots, robot_path, robot_urdf_path
from equipoise.robots.measures import measure
from equipoise.scenarios import parse_scenario, read_scenario, resolved_text
from helpers import HUMANOIDS

OTHERS = sorted(set(HUMANOIDS) - {"hrp2"})


@pytest.fixture(params=OTHERS)
def other(request: pytest.FixtureRequest) -> str:
    missing = named_robots()[request.param].missing
    if missing:
        pytest.skip(f"{request.param} is not installed: {missing}")
    return request.param


@pytest.mark.parametrize("name", ["tray", "telephone", "press", "sphere"])
def test_on_a_copy_of_its_own_robot_nothing_changes(name: str, tmp_path: Path) -> None:
    for suffix in (".urdf", ".srdf", ".yaml"):
        shutil.copy(robot_urdf_path("hrp2").with_suffix(suffix), tmp_path / f"copy{suffix}")
    before = read_scenario(name)
    after = read_scenario(name, robot=str(tmp_path / "copy.yaml"))
    names = {"robot": before.robot, "title": before.title}
    tree = after.model_dump() | names
    for task, spec in before.tasks.items():  # pairs of a part of two links are regrouped
        if "pairs" in tree["tasks"][task]:
            pairs = tree["tasks"][task].pop("pairs")
            assert {tuple(pair) for pair in pairs} >= {tuple(pair) for pair in spec.pairs}
            tree["tasks"][task]["pairs"] = spec.pairs
    assert flat(tree) == pytest.approx(flat(before.model_dump()), abs=1e-6)


def flat(tree: object, path: str = "") -> dict[str, object]:
    """Return the numbers of a tree by their paths, text as its hash."""
    if isinstance(tree, dict):
        return {k: v for key in tree for k, v in flat(tree[key], f"{path}.{key}").items()}
    if isinstance(tree, list):
        return {k: v for i, x in enumerate(tree) for k, v in flat(x, f"{path}.{i}").items()}
    return {path: float(hash(tree) if isinstance(tree, str) or tree is None else tree)}


def test_figures_stay_similar(other: str) -> None:
    """Distances of waypoints from the shoulders, and of corners of the world, have one ratio."""
    before, after = read_scenario("press"), read_scenario("press", robot=other)
    old, new = measure(get_robot("hrp2")), measure(get_robot(other))
    ratio = new.reach / old.reach
    ways = [
        np.array([w.xyz for w in scenario.tasks["right_hand"].waypoints])
        for scenario in (before, after)
    ]
    assert ways[1] - new.p_world_shoulders == pytest.approx(
        ratio * (ways[0] - old.p_world_shoulders), abs=1e-5
    )
    assert after.tasks["com"].margin / before.tasks["com"].margin == pytest.approx(
        new.stance / old.stance, rel=1e-4
    )
    assert after.contacts["press"].force == before.contacts["press"].force


def test_the_wall_stays_where_it_is_pressed(other: str) -> None:
    scenario = read_scenario("press", robot=other)
    box = scenario.world.bodies["wall"].shapes[0]
    place = np.array(scenario.world.bodies["wall"].at.xyz) + box.at.xyz
    face = place[1] + box.box[1] / 2
    assert scenario.contacts["press"].surface.at.xyz[1] == pytest.approx(face, abs=1e-5)
    assert scenario.tasks["left_hand"].waypoints[0].xyz[1] == pytest.approx(face, abs=1e-5)


def test_links_are_those_of_the_same_part(other: str) -> None:
    before, after = read_scenario("tray"), read_scenario("tray", robot=other)
    part_of = {
        name: {link: part for part, links in get_robot(name).parts.items() for link in links}
        for name in ("hrp2", other)
    }
    wanted, found = (
        {frozenset(part_of[name].get(x, x) for x in pair) for pair in pairs}
        for name, pairs in (
            ("hrp2", before.tasks["obstacles"].pairs),
            (other, after.tasks["obstacles"].pairs),
        )
    )
    assert found == wanted


def test_it_reads_back_as_it_was_written(other: str) -> None:
    scenario = read_scenario("tray", robot=other)
    assert parse_scenario(resolved_text(scenario)) == scenario
    assert scenario.robot == other


def test_exceptions_are_in_the_measures_of_the_file(tmp_path: Path) -> None:
    copy = Path(shutil.copytree(robot_path("hrp2").parent, tmp_path / "hrp2"))
    path = tmp_path / "mine.yaml"
    name = str(copy / "hrp2.yaml")
    path.write_text(
        f"extends: press\nname: mine\nfor_robot:\n  {name}: {{tasks: {{com: {{margin: 0.05}}}}}}\n",
        encoding="utf-8",
    )
    assert read_scenario(str(path)).tasks["com"].margin == 0.09
    assert read_scenario(str(path), robot=name).tasks["com"].margin == pytest.approx(0.05)
    path.write_text("extends: press\nname: mine\nfor_robot: {talos: 3}\n", encoding="utf-8")
    with pytest.raises(ScenarioError, match="for_robot"):
        read_scenario(str(path), robot=name)


def test_a_link_without_a_counterpart_is_refused(tmp_path: Path) -> None:
    copy = Path(shutil.copytree(robot_path("hrp2").parent, tmp_path / "hrp2")) / "hrp2.yaml"
    text = copy.read_text(encoding="utf-8")
    copy.write_text(text.replace("  left_hand: LARM_LINK5\n", ""), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"LARM_LINK5.*no counterpart.*parts"):
        read_scenario("tray", robot=str(copy))


def test_a_robot_without_hands_is_refused(tmp_path: Path) -> None:
    shutil.copy(robot_urdf_path("hrp2"), tmp_path / "bare.urdf")
    with pytest.raises(Exception, match="cannot be measured: it needs two palms"):
        read_scenario("tray", robot=str(tmp_path / "bare.urdf"))
