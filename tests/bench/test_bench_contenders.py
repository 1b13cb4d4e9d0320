"""The contenders are given the same robot and the same hands, and nothing is kept in memory."""

from __future__ import annotations

import ast
import gc
import json
import shutil
import sys

import numpy as np
import pinocchio as pin
import pytest

from equipoise.bench import peers, subprocess_peer
from equipoise.bench.equipoise_contenders import DaqpBeside, HardCase, OwnParts, OwnTick, variants
from equipoise.bench.interleave import interleave
from equipoise.bench.memory import measure_memory
from equipoise.bench.problem import HANDS, PAIRS, Problem, make_problem
from equipoise.bench.rows import Row
from equipoise.bench.scaling import growth, linear_share
from equipoise.bench.subprocess_peer import ApartPeer, write_task
from equipoise.bench.unreachable_targets import EVERY, TOO_FAR, throw_hands
from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots.measures import measure

TICKS = 40


@pytest.fixture(scope="module")
def problem() -> Problem:
    """The tray on HRP-2."""
    return make_problem("hrp2")


def test_the_task_set_is_the_one_that_is_promised(problem):
    names = [{task.name for task in level} for level in problem.levels]
    assert names[0] == {"contacts", "left_foot", "right_foot", "com"}
    assert names[1] == {"left_hand", "right_hand", "limits"}
    assert names[2] == {"look", "obstacles"}
    scene = problem.simulation.setup.scene
    assert len(problem.pairs) == PAIRS == 8
    for pair in problem.pairs:
        assert len(scene.shapes_of(pair.first)) == len(scene.shapes_of(pair.second)) == 1


def test_our_rows_are_there_and_nothing_fails(problem):
    made = [OwnTick(problem), OwnParts(problem), DaqpBeside(problem, "tray"), HardCase(problem)]
    made += variants(problem)
    rows = {row.name: row for row in interleave(made, TICKS)}
    assert set(rows) == {
        *("tick/hrp2/tray", "tick/hrp2/rows", "tick/hrp2/law", "tick/hrp2/call"),
        *("tick/hrp2/move", "tick/hrp2/pairs", "tick/hrp2/all_pairs", "tick/hrp2/plain"),
        *("hqp/hrp2/tray", "rigid/hrp2/tray", "daqp/hrp2/tray", "hqp/hrp2/hard"),
    }
    for row in rows.values():
        assert 0.0 < row.median_us <= row.p99_us
        assert row.failures == 0
    assert gc.isenabled()


def test_thrown_hands_are_out_of_reach(problem):
    sizes = measure(problem.robot)
    levels = throw_hands(problem, HANDS)
    tasks = {task.name: task for level in levels for task in level}
    period = EVERY * problem.dt
    for k in range(6):
        here = [tasks[h].target.at(k * period).T_world_target.translation for h in HANDS]
        way = problem.frame_tasks()[HANDS[0]].target
        drift = way.at(k * period).T_world_target.translation
        drift = drift - way.at(0.0).T_world_target.translation
        far = np.mean(here, axis=0) - drift - sizes.p_world_shoulders
        assert np.linalg.norm(far) == pytest.approx(sizes.reach + TOO_FAR, abs=1e-9)
        jumped = tasks[HANDS[0]].target.at((k + 1) * period - 1e-6).T_world_target.translation
        assert np.allclose(jumped, here[0], atol=1e-3)
        after = tasks[HANDS[0]].target.at((k + 1) * period).T_world_target.translation
        assert np.linalg.norm(after - jumped) > 0.1


def test_pink_and_mink_follow_the_same_hands(problem):
    pytest.importorskip("pink")
    pytest.importorskip("mink")
    from equipoise.bench.mink_peer import MinkPeer
    from equipoise.bench.pink_peer import PinkPeer

    t = (TICKS + 400) * problem.dt  # under way
    for make in (PinkPeer, MinkPeer):
        for collisions in (False, True):
            peer = make(problem, collisions=collisions)
            peer.run(400, TICKS)
            peer.run(400 + TICKS, 1)
            assert peer.failures[peer.row] == 0
            for name, task in problem.frame_tasks().items():
                wanted = task.target.at(t).T_world_target.translation
                assert np.allclose(peer.place_of(name), wanted, atol=1e-5), (peer.row, name)


def test_peers_apart_are_given_the_same_robot(problem, tmp_path):
    write_task(problem, tmp_path, 3)
    task = json.loads((tmp_path / "task.json").read_text())
    targets = np.load(tmp_path / "targets.npz")
    model = pin.buildModelFromUrdf(task["urdf"], pin.JointModelFreeFlyer())
    assert list(model.names)[2:] == task["joints"]
    found = model.createData()
    pin.framesForwardKinematics(model, found, np.array(task["q_start"]))
    for name, link in task["links"].items():
        T = found.oMf[model.getFrameId(link)]
        assert np.allclose(T.homogeneous, targets[name][0], atol=1e-4), name
    for foot in task["feet"]:
        T = found.oMf[model.getFrameId(task["links"][foot])]
        heights = [T.act(np.array(corner))[2] for corner in task["soles"][foot]]
        assert np.allclose(heights, 0.0, atol=1e-6)


def test_what_is_not_installed_is_left_out_with_a_word(problem, monkeypatch):
    gone = peers.Peer("nothing_like_it", "some-package", "")
    known = peers.PEERS["placo"]
    monkeypatch.setattr(peers, "PEERS", {"gone": gone, "placo": known})
    said: list[str] = []
    assert peers.make_peers(problem, {}, 10, said.append) == []
    assert "pip install some-package" in said[0]
    assert "--peer-python placo=PATH" in said[1]


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("placo", InputError, "NAME=PATH"),
        ("plako=/usr/bin/python3", NameNotFoundError, "placo"),
        ("pink=/usr/bin/python3", InputError, "pip install pin-pink"),
    ],
)
def test_wrong_names_of_peers_are_refused(text, kind, message):
    with pytest.raises(kind, match=message):
        peers.parse_pythons([text])


@pytest.mark.parametrize("python", ["/nowhere/python", sys.executable])
def test_a_python_without_the_peer_is_refused_kindly(problem, python):
    if python == sys.executable and not peers.missing_of(peers.PEERS["tsid"]):
        pytest.skip("tsid is importable here")
    with pytest.raises(InputError, match="Name a Python that can `import tsid`"):
        ApartPeer(problem, "tsid", python, 3)


WORKER = """
from protocol import serve


class Tick:
    def __init__(self, task, targets):
        self.ticks = [len(poses) for poses in targets.values()]
        assert len(task["joints"]) == len(task["velocity_max"])

    def run(self, k):
        print("a library that talks")
        return 10 * k + self.ticks[0], int(k == 4)

    def error(self, k):
        return 0.5


if __name__ == "__main__":
    serve(Tick, "a stand-in")
"""


def test_a_worker_is_told_its_ticks_and_answers_with_their_times(problem, tmp_path, monkeypatch):
    shutil.copy(subprocess_peer.WORKERS / "protocol.py", tmp_path)
    (tmp_path / "simple_worker.py").write_text(WORKER, encoding="utf-8")
    monkeypatch.setattr(subprocess_peer, "WORKERS", tmp_path)
    peer = ApartPeer(problem, "simple", sys.executable, 6)
    try:
        assert peer.remarks == {peer.row: "a stand-in"}
        assert peer.run(0, 3) == {peer.row: [6, 16, 26]}
        assert peer.failures == {peer.row: 0}
        assert peer.run(3, 3) == {peer.row: [36, 46, 56]}
        assert peer.failures == {peer.row: 1}
    finally:
        peer.close()


def test_workers_need_nothing_of_ours():
    """They run where Equipoise is not installed; what they share lies beside them."""
    paths = sorted(subprocess_peer.WORKERS.glob("*.py"))
    beside = {path.stem for path in paths}
    assert {"protocol", "placo_worker", "tsid_worker"} <= beside
    for path in paths:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        named = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
        named |= {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
        peer = {path.stem.removesuffix("_worker")}
        known = {"numpy", "pinocchio", *beside, *peer, *sys.stdlib_module_names}
        assert {name.split(".")[0] for name in named} <= known, path.name


def test_memory_does_not_grow(problem):
    found = measure_memory(problem, 1000)
    assert found.passed, str(found)


@pytest.mark.slow
def test_memory_does_not_grow_over_many_ticks(problem):
    found = measure_memory(problem, 20_000)
    assert found.passed, str(found)


def test_the_tables_of_growth_are_whole():
    rows = growth(2)
    tables = {row.name.split("/")[1] for row in rows}
    assert tables == {"dof", "tasks", "levels", "contacts", "pairs", "rows", "unknowns"}
    assert all(row.median_us > 0.0 and row.failures == 0 for row in rows)


@pytest.mark.parametrize(("power", "share"), [(1, 1.0), (2, 8.0 / 3.0)])
def test_the_bend_of_a_table_of_rows_is_measured(power, share):
    rows = [
        Row(f"growth/rows/{m}", 30.0 + 0.1 * float(m) ** power, 1e9)
        for m in (50, 100, 200, 400, 800)
    ]
    assert linear_share(rows) == pytest.approx(share)
