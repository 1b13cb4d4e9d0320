"""The report: self-contained, honest about what is missing, and its replay true to Pinocchio."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from figure_runs import channels, made_run, tray_places

from equipoise.analysis.rendering.sole_arrows import SOLE_SCALE
from equipoise.analysis.report.page import make_report
from equipoise.analysis.report.replay_export import Blobs, export_replay
from equipoise.analysis.report.tables import metrics_table, properties, quantity
from equipoise.errors import InputError, RunLogError
from equipoise.runlog import RunWriter, write_summary
from equipoise.scenarios import read_scenario

PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


def write_run(folder: Path, ticks: int = 120, title: str = "A run") -> Path:
    run = made_run(ticks)
    with RunWriter(folder, channels(), scenario_text=run.scenario_text, seed=0) as writer:
        for k in range(ticks):
            writer.write(float(run.t[k]), {name: run[name][k] for name in run})
    (folder / "figures").mkdir()
    (folder / "figures" / "joints.png").write_bytes(PIXEL)
    rows = {
        "speed": {"value": 0.004, "unit": "m", "doc": "how near", "wanted": {"max": 0.001}}
        | {"passed": False},
        "force": {"value": 2.0, "unit": "N", "doc": "how hard"},
    }
    summary = {"title": title, "passed": False, "metrics": rows, "gains": ["K_d = 3 M"]}
    write_summary(folder, summary | {"versions": {"numpy": "9.9"}, "simulated_s": 0.12})
    return folder


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    root = tmp_path_factory.mktemp("report")
    runs = [write_run(root / name, title=f"<b>{name}</b>") for name in ("one", "two")]
    return make_report(runs, root / "out" / "report.html").read_text(encoding="utf-8")


class Links(HTMLParser):
    """Collects every address in a page and every tag."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        wanted = ("src", "href", "data", "action", "poster", "srcset")
        self.addresses += [value or "" for name, value in attrs if name in wanted]


def test_nothing_is_fetched(page: str) -> None:
    links = Links()
    links.feed(page)
    assert len(links.addresses) == 2  # one figure of each run
    assert all(address.startswith("data:image/png;base64,") for address in links.addresses)
    assert "default-src 'none'" in page
    assert not re.search(r"@import|url\(|fetch\(|XMLHttpRequest|WebSocket|import\(", page)
    assert base64.b64encode(PIXEL).decode() in page
    assert links.tags.count("canvas") == 2


def test_texts_cannot_become_markup(page: str) -> None:
    assert "<b>one</b>" not in page
    assert "&lt;b&gt;one&lt;/b&gt;" in page
    assert "{{" not in page.split("<script")[0]


def test_runs_stand_side_by_side(page: str) -> None:
    table = page[page.index("<table>") : page.index("</table>")]
    assert table.index("one") < table.index("two")
    assert table.count("4 mm") == 2
    assert table.count("≤ 1 mm") == 2
    assert table.count("missed") == 2
    assert "not met" in page
    assert "9.9" in page
    assert page.count("SHA-256") == 2


def replays(page: str) -> dict:
    found = re.search(r'<script id="replays" type="application/json">(.*?)</script>', page, re.S)
    assert found is not None
    return json.loads(found.group(1))


def test_the_replay_is_where_pinocchio_puts_it(page: str) -> None:
    content = replays(page)
    first, second = content["runs"]
    assert first["meshes"] == second["meshes"]  # kept once, used twice
    poses = np.frombuffer(base64.b64decode(content["blobs"][first["poses"]]), "<f4")
    times = np.frombuffer(base64.b64decode(content["blobs"][first["times"]]), "<f4")
    poses = poses.reshape(len(times), first["nodes"], 7)
    run, robot = made_run(120), tray_places().robot
    data = robot.model.createData()
    for k in (0, len(times) - 1):
        tick = int(np.argmin(np.abs(run.t - times[k])))
        pin.forwardKinematics(robot.model, data, run["q"][tick].copy())
        for joint in (1, 7, robot.model.njoints - 1):
            wanted = pin.SE3ToXYZQUAT(data.oMi[joint])
            assert np.allclose(poses[k, joint], wanted, atol=1e-6)
    for mesh in first["meshes"]:
        triangles = np.frombuffer(base64.b64decode(content["blobs"][mesh["triangles"]]), "<u4")
        setup = np.frombuffer(base64.b64decode(content["blobs"][mesh["places"]]), "<f4")
        normals = np.frombuffer(base64.b64decode(content["blobs"][mesh["normals"]]), "i1")
        assert len(triangles) == mesh["count"]
        assert triangles.max() < len(setup) / 3 == len(normals) / 4
        assert mesh["node"] < first["nodes"]


def test_a_long_run_is_thinned_and_its_last_moment_kept() -> None:
    run, blobs = made_run(4000), Blobs()
    replay = export_replay(run, read_scenario("tray"), tray_places(), blobs)
    assert replay is not None
    times = np.frombuffer(base64.b64decode(blobs.texts[replay["times"]]), "<f4")
    assert 95 <= len(times) <= 105
    assert times[0] == 0.0
    assert times[-1] == np.float32(run.t[-1])


def test_the_floor_pushes_from_below_the_soles_edge_up() -> None:
    """What the page draws of the soles' forces begins on the floor and adds up to the forces."""
    made, blobs, setup = made_run(120), Blobs(), tray_places()
    rng = np.random.default_rng(6)
    forces = {
        f"lam/{contact.name}": rng.normal(
            loc=(0.0, 0.0, 30.0, 0.0, 0.0, 0.0), scale=20.0, size=(120, 6)
        )
        for contact in setup.soles.contacts
    }
    run = replace(made, arrays={**made.arrays, **forces})
    replay = export_replay(run, read_scenario("tray"), setup, blobs)
    assert replay is not None
    times = np.frombuffer(base64.b64decode(blobs.texts[replay["times"]]), "<f4")
    lines = np.frombuffer(base64.b64decode(blobs.texts[replay["lines"]]), "<f4")
    drawn = lines.reshape(len(times), replay["segments"], 2, 3)
    ticks = [int(np.argmin(np.abs(run.t - t))) for t in times]
    for contact, lines in zip(
        setup.soles.contacts, np.split(drawn, len(setup.soles.contacts), axis=1), strict=True
    ):
        lam, sole = run[f"lam/{contact.name}"][ticks], contact.sole
        places = [setup.robot.at(run["q"][k]).placement(sole.frame) for k in ticks]
        loaded = lam[:, 2] > 0.0
        assert loaded.any()
        found = zip(places, lines[:, 0].astype(float), strict=True)
        inside = np.array([[T.actInv(tail), T.actInv(tip)] for T, (tail, tip) in found])
        tails = inside[loaded, 0]
        assert np.allclose(tails[:, 2], 0.0, atol=1e-6)
        assert np.allclose(tails[:, 0], -lam[loaded, 4] / lam[loaded, 2], atol=1e-6)
        assert ((tails[:, 1] > sole.y_max) | (tails[:, 1] < sole.y_min)).all()
        ways = inside[:, 1] - inside[:, 0]
        assert np.allclose(ways[loaded] / SOLE_SCALE, lam[loaded, :3], atol=1e-2)
        assert (lines[~loaded] == 0.0).all()
        for barb in (lines[loaded, 1], lines[loaded, 2]):
            assert np.array_equal(barb[:, 0], lines[loaded, 0, 1])
            back = barb[:, 1] - barb[:, 0]
            assert (np.sum(back * (lines[loaded, 0, 0] - barb[:, 0]), axis=1) > 0.0).all()


def test_a_run_that_was_killed_is_reported_as_far_as_it_goes(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "killed")
    content = (folder / "run.mcap").read_bytes()
    (folder / "run.mcap").write_bytes(content[: int(0.7 * len(content))])
    (folder / "summary.json").unlink()
    page = make_report([folder], tmp_path / "report.html").read_text(encoding="utf-8")
    assert "breaks off" in page
    assert "left no summary" in page
    assert replays(page)["runs"][0] is not None
    assert 'class="met"' not in page


def test_foreign_and_empty_files_get_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "run.mcap").write_bytes(b"")
    with pytest.raises(RunLogError, match="is empty"):
        make_report([tmp_path], tmp_path / "report.html")
    with pytest.raises(InputError, match="at least one run"):
        make_report([], tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def test_tables_show_what_only_one_run_has() -> None:
    table = metrics_table([("a", {"x": {"value": 1.0, "doc": "X"}}), ("b", {})])
    assert table.count("<td></td>") == 3  # nothing is wanted of a, and b has nothing
    assert "No run has" in metrics_table([("a", {})])
    assert quantity(0.0025, "m") == "2.5 mm"
    assert quantity(None, "N") == "–"
    assert "<dd>1, 2</dd>" in properties({"a": [1, 2], "empty": ""})
    assert "&lt;i&gt;" in properties({"<i>": {"deep": "<i>"}})
