"""What other programs read of a log, by the public schemas and names alone."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from equipoise import run_scenario
from equipoise.analysis.export_run import export_run
from equipoise.analysis.foxglove.pictures import RATE
from equipoise.analysis.foxglove.write import LAYOUT_NAME, add_pictures
from equipoise.analysis.run_context import RunContext
from equipoise.errors import InputError, RunLogError
from equipoise.runlog import check_log, load_run
from equipoise.runlog.topics import Topic, add_topics

PUBLIC = {"/tf": FrameTransforms, "/scene": SceneUpdate, "/joint_states": JointStates,
          "/forces": SceneUpdate}  # fmt: skip


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """A run of a fifth of a second without pictures."""
    folder = tmp_path_factory.mktemp("bare") / "run"
    return run_scenario("tray", out=folder, overrides=["duration=0.4"], figures=False)


@pytest.fixture(scope="module")
def shown(bare, tmp_path_factory):
    """The same with pictures."""
    folder = tmp_path_factory.mktemp("shown") / "run"
    shutil.copytree(bare.folder, folder)
    add_pictures(RunContext.of(load_run(folder)))
    return load_run(folder)


def _read(folder: Path) -> dict[str, list]:
    """Decode every message with the classes of the public package, checksums included."""
    found: dict[str, list] = {topic: [] for topic in PUBLIC}
    with open(folder / "run.mcap", "rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            kind = PUBLIC.get(channel.topic)
            if kind is not None:
                assert (schema.name, schema.encoding) == (kind.DESCRIPTOR.full_name, "protobuf")
                found[channel.topic].append((message.log_time, kind.FromString(message.data)))
    return found


def test_links_are_where_the_logged_configuration_puts_them(shown):
    model = RunContext.of(shown).setup.robot.model
    data = model.createData()
    messages = _read(shown.folder)["/tf"]
    assert len(messages) == int(shown.t[-1] * RATE) + 1
    for t, message in messages:
        pin.framesForwardKinematics(model, data, np.array(shown["q"][shown.at(t * 1e-9)]))
        checked = 0
        for one in message.transforms:
            assert one.parent_frame_id == "world"
            if not model.existFrame(one.child_frame_id, pin.FrameType.BODY):
                continue
            frame = model.frames[model.getFrameId(one.child_frame_id, pin.FrameType.BODY)]
            wanted = data.oMi[frame.parentJoint]
            at = one.translation
            assert np.allclose([at.x, at.y, at.z], wanted.translation, atol=1e-12)
            checked += 1
        assert checked >= model.njoints - 1


def test_joint_states_are_the_log_by_name(shown):
    robot = RunContext.of(shown).setup.robot
    for t, message in _read(shown.folder)["/joint_states"]:
        k = shown.at(t * 1e-9)
        assert tuple(one.name for one in message.joints) == robot.joint_names
        assert [one.position for one in message.joints] == shown["q"][k, 7:].tolist()
        assert [one.velocity for one in message.joints] == shown["v"][k, 6:].tolist()
        assert [one.effort for one in message.joints] == shown["tau"][k].tolist()


def test_the_scene_shows_robot_and_world_in_frames_that_exist(shown):
    found = _read(shown.folder)
    ((_, scene),) = found["/scene"]
    frames = {one.child_frame_id for one in found["/tf"][0][1].transforms}
    assert {entity.frame_id for entity in scene.entities} <= frames
    names = {entity.id for entity in scene.entities}
    assert {"world/desk", "world/tray"} <= names
    assert sum(name.startswith("robot/") for name in names) > 20
    for entity in scene.entities:
        shapes = [entity.cubes, entity.spheres, entity.cylinders, entity.triangles]
        assert any(shapes), entity.id
        for triangles in entity.triangles:
            assert max(triangles.indices) < len(triangles.points)


def test_the_arrows_of_the_soles_carry_the_robot(shown):
    """Lengths of the upright arrows [m] times 1000 N/m are what the log says the floor gives."""
    t, update = _read(shown.folder)["/forces"][-1]
    k = shown.at(t * 1e-9)
    measured = {one.id: one for one in update.entities}["measured"]
    up = 0.0
    for arrow in measured.arrows:
        turn = arrow.pose.orientation
        x_axis = pin.Quaternion(turn.w, turn.x, turn.y, turn.z).toRotationMatrix()[:, 0]
        if x_axis[2] > 0.9:
            up += 1000.0 * (arrow.shaft_length + arrow.head_length) * x_axis[2]
    logged = shown["lam/left_sole"][k, 2] + shown["lam/right_sole"][k, 2]
    assert up == pytest.approx(logged, rel=1e-6)
    assert {one.id: one for one in update.entities}["wanted"].arrows


def test_every_number_has_its_name(shown):
    with open(shown.folder / "run.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        ticks = [tick for *_, tick in reader.iter_decoded_messages(topics=["/tick"])]
    assert len(ticks) == shown.t.size
    joint = shown.channels["tau"].labels[3]
    assert [getattr(tick.tau, joint) for tick in ticks] == shown["tau"][:, 3].tolist()


def test_numbers_and_notices_stay_as_they_were(bare, shown):
    assert (shown.complete, shown.note, check_log(shown.folder)) == (True, "", "")
    for name in bare.names:
        assert shown[name].tobytes() == bare[name].tobytes()
    before, after = (os.path.getsize(one.folder / "run.mcap") for one in (bare, shown))
    assert after < 1.25 * before


def test_adding_twice_is_adding_once(shown, tmp_path):
    again = tmp_path / "again"
    shutil.copytree(shown.folder, again)
    add_pictures(RunContext.of(load_run(again)))
    assert (again / "run.mcap").read_bytes() == (shown.folder / "run.mcap").read_bytes()


def test_damaged_pictures_are_told_and_cost_no_number(shown, tmp_path):
    with open(shown.folder / "run.mcap", "rb") as stream:
        summary = make_reader(stream).get_summary()
    tick = next(number for number, one in summary.channels.items() if one.topic == "/tick")
    content = bytearray((shown.folder / "run.mcap").read_bytes())
    first = next(c for c in summary.chunk_indexes if tick not in c.message_index_offsets)
    content[first.chunk_start_offset + first.chunk_length // 2] ^= 0x10
    (tmp_path / "run.mcap").write_bytes(content)
    assert "pictures" in check_log(tmp_path)
    assert load_run(tmp_path)["q"].tobytes() == shown["q"].tobytes()


def test_a_log_that_breaks_off_is_refused_and_left_as_it_is(bare, tmp_path):
    whole = (bare.folder / "run.mcap").read_bytes()
    (tmp_path / "run.mcap").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(RunLogError, match="not whole"):
        add_pictures(RunContext.of(load_run(tmp_path)))
    assert (tmp_path / "run.mcap").read_bytes() == whole[: len(whole) // 2]
    assert [one.name for one in tmp_path.iterdir()] == ["run.mcap"]


def test_the_topic_of_the_ticks_is_not_given_away(shown):
    with pytest.raises(InputError, match="belongs to the ticks"):
        add_topics(shown.folder / "run.mcap", [Topic("/tick", "x", b"", [])])


def test_the_layout_plots_fields_that_exist(shown):
    layout = json.loads((shown.folder / LAYOUT_NAME).read_text())
    with open(shown.folder / "run.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        tick = next(tick for *_, tick in reader.iter_decoded_messages(topics=["/tick"]))
    paths = [p["value"] for panel in layout["configById"].values() for p in panel.get("paths", ())]
    assert len(paths) > 10
    for path in paths:
        topic, channel, label = path.split(".")
        assert topic == "/tick"
        assert isinstance(getattr(getattr(tick, channel), label), float)


def test_every_format_holds_the_numbers(shown, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    path, note = export_run(shown.folder, "parquet", tmp_path / "run.parquet")
    table = parquet.read_table(path)
    assert note == ""
    assert (
        table["tau[RLEG_JOINT0] (N m)"].to_pylist()
        == shown["tau"][:, shown.channels["tau"].labels.index("RLEG_JOINT0")].tolist()
    )
    path, _ = export_run(shown.folder, "npz", tmp_path / "run.npz")
    with zipfile.ZipFile(path) as archive:
        assert "q.npy" in archive.namelist()
    path, _ = export_run(shown.folder, "mcap", tmp_path / "copy.mcap")
    assert load_run(path)["q"].tobytes() == shown["q"].tobytes()


def test_rerun_reads_its_recording(shown, tmp_path):
    """Rerun's own command finds the recording sound, and the numbers and links in it by name."""
    pytest.importorskip("rerun", reason="needs the extra 'rerun': pip install -e '.[rerun]'")
    path, _ = export_run(shown.folder, "rrd", tmp_path / "run.rrd")

    def rrd(command: str) -> str:
        asked = [sys.executable, "-m", "rerun", "rrd", command, str(path)]
        return subprocess.run(asked, capture_output=True, text=True, check=True).stdout

    rrd("verify")
    told = rrd("print")
    for name in ("/numbers/tau/RLEG_JOINT3", "/numbers/lam/grasp", "/scene/RLEG_JOINT3"):
        assert name in told
