"""A run as a recording of Rerun: every number by its name, and the robot in its world."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.analysis.rendering.part import Part
from equipoise.analysis.rendering.scene_meshes import SceneMeshes
from equipoise.analysis.run_context import RunContext
from equipoise.errors import InputError, RunLogError
from equipoise.runlog import Run
from equipoise.runlog.field_names import field_names
from equipoise.spatial import POSE_SIZE

RATE = 30.0  # [1/s] pictures
TIMELINE = "t"


def export_rrd(run: Run, path: Path) -> None:
    """Write numbers at full rate and pictures at a reduced one, for `rerun FILE`.

    Raises: InputError without the package rerun-sdk; RunLogError if the file cannot be written.
    """
    try:
        import rerun
    except ImportError:
        remedy = "pip install 'equipoise[rerun]', or choose another format"
        raise InputError("rrd needs the package rerun-sdk", remedy=remedy) from None
    try:
        path.open("wb").close()
    except OSError as error:
        raise RunLogError(f"Cannot write {path}: {error.strerror}.") from error
    recording = rerun.RecordingStream("equipoise", recording_id=run.folder.name)
    recording.save(str(path))
    recording.log("/", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    _send_numbers(rerun, recording, run)
    context = RunContext.of(run)
    if context.drawable:
        _send_pictures(rerun, recording, context)
    recording.flush()
    recording.disconnect()


def _send_numbers(rerun: ModuleType, recording: Any, run: Run) -> None:
    index = rerun.TimeColumn(TIMELINE, duration=run.t)
    for name, channel in run.channels.items():
        for k, label in enumerate(field_names(channel.labels)):
            numbers = np.ascontiguousarray(run[name][:, k])
            columns = rerun.Scalars.columns(scalars=numbers)
            recording.send_columns(f"/numbers/{name}/{label}", indexes=[index], columns=columns)


def _send_pictures(rerun: ModuleType, recording: Any, context: RunContext) -> None:
    """Send the shapes once, each under the joint that carries it, and where the joints are."""
    run, scene = context.run, context.setup.scene
    meshes = SceneMeshes(scene, frozenset(context.setup.sliders))
    by_joint: dict[int, list[Part]] = defaultdict(list)
    for part in meshes.parts:
        by_joint[part.joint].append(part)
    for joint, parts in by_joint.items():
        for k, part in enumerate(parts):
            shape = rerun.Mesh3D(
                vertex_positions=part.mesh.vertices,
                vertex_normals=part.mesh.normals,
                triangle_indices=part.mesh.triangles,
                albedo_factor=[*(round(255 * float(c)) for c in part.rgb), 255],
            )
            recording.log(f"/scene/{_name(meshes.model, joint)}/shape{k}", shape, static=True)
    count = int((run.t[-1] - run.t[0]) * RATE) + 1
    wanted = run.t[0] + np.arange(count) / RATE - 1e-9
    ticks = np.unique(np.searchsorted(run.t, wanted).clip(0, len(run.t) - 1))
    ticks = ticks[np.isfinite(run["q"][ticks]).all(axis=1)]
    data = meshes.model.createData()
    poses = np.zeros((len(ticks), meshes.model.njoints, POSE_SIZE))
    for i, k in enumerate(ticks):
        pin.forwardKinematics(meshes.model, data, np.array(run["q"][k]))
        poses[i] = [pin.SE3ToXYZQUAT(T) for T in data.oMi]
    index = rerun.TimeColumn(TIMELINE, duration=run.t[ticks])
    for joint in by_joint:
        columns = rerun.Transform3D.columns(
            translation=poses[:, joint, :3], quaternion=poses[:, joint, 3:]
        )
        path = f"/scene/{_name(meshes.model, joint)}"
        recording.send_columns(path, indexes=[index], columns=columns)


def _name(model: pin.Model, joint: int) -> str:
    return "world" if joint == 0 else str(model.names[joint])
