"""The topics of a run: where every link is, what it looks like, joint states, forces."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from equipoise.analysis.foxglove.messages import (
    WORLD,
    add_arrow,
    add_mesh,
    add_shape,
    stamp,
    topic,
)
from equipoise.analysis.rendering.body_poses import body_pose, carrier_of
from equipoise.analysis.rendering.force_arrows import ForceArrows
from equipoise.analysis.rendering.scene_meshes import robot_parts
from equipoise.analysis.rendering.stands import stands
from equipoise.analysis.run_context import RunContext
from equipoise.errors import InputError
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.runlog import Run
from equipoise.runlog.packing import nanoseconds
from equipoise.runlog.topics import Topic
from equipoise.spatial import Array, Indices

RATE = 30.0  # [1/s] pictures
TRANSFORMS, SCENE, JOINTS, FORCES = "/tf", "/scene", "/joint_states", "/forces"
MEASURED_RGB, WANTED_RGB = np.array([0.84, 0.16, 0.16]), np.array([1.0, 0.67, 0.0])


def picture_topics(context: RunContext, rate: float = RATE) -> list[Topic]:
    """Return the topics of a run's pictures, `rate` a second.

    Raises: InputError for a run of which no picture can be made.
    """
    if not context.drawable:
        raise InputError(
            "there is nothing to draw",
            given=context.run.folder.name,
            remedy="Give a run that has ticks and whose scenario this version can read",
        )
    return _Pictures(context, rate).topics()


class _Pictures:
    """Makes the messages of every topic, tick by tick."""

    def __init__(self, context: RunContext, rate: float) -> None:
        self._run, self._setup = context.run, context.setup
        robot = self._setup.robot
        self._robot = robot
        self._evaluator = KinematicsEvaluator(robot)
        self._frames = _link_names(robot.model)
        self._arrows = ForceArrows(self._setup)
        self._ticks = _ticks(context.run, rate)

    def topics(self) -> list[Topic]:
        times = nanoseconds(self._run.t[self._ticks]).tolist()
        transforms, joints, forces = [], [], []
        for t, k in zip(times, self._ticks, strict=True):
            kin = self._evaluator.at(self._run["q"][k], np.zeros(self._robot.nv))
            transforms.append((t, self._transforms(kin, k, t)))
            joints.append((t, self._joints(k, t)))
            forces.append((t, self._forces(kin, k, t)))
        scene = [(times[0], self._scene(times[0]))]
        return [
            topic(TRANSFORMS, transforms),
            topic(SCENE, scene),
            topic(JOINTS, joints),
            topic(FORCES, forces),
        ]

    def _scene(self, t: int) -> SceneUpdate:
        """Return what there is to see, each shape in the axes of what carries it; sent once."""
        update, entities = SceneUpdate(), {}
        for part in robot_parts(self._robot):
            frame = self._frames[part.joint]
            if frame not in entities:
                entities[frame] = _entity(update, f"robot/{frame}", frame, t)
            known = part.shape is not None and part.placement is not None
            if not (known and add_shape(entities[frame], part.shape, part.placement, part.rgb)):
                add_mesh(entities[frame], part.mesh, part.rgb)
        scene = self._setup.scene
        posts = stands(scene, frozenset(self._setup.sliders))
        if posts:
            entity = _entity(update, "world/stands", WORLD, t)
            for part in posts:
                add_mesh(entity, part.mesh, part.rgb)
        for body in self._setup.scene.bodies:
            entity = _entity(update, f"world/{body.name}", body.name, t)
            _, T_joint_body = carrier_of(self._setup, body)
            for index in scene.shapes_of(body.name):
                shape = scene.geometry.geometryObjects[index]
                rgb = np.clip(np.asarray(shape.meshColor, dtype=float)[:3], 0.0, 1.0)
                add_shape(entity, shape.geometry, T_joint_body.actInv(shape.placement), rgb)
        return update

    def _transforms(self, kin: Kinematics, k: int, t: int) -> FrameTransforms:
        message = FrameTransforms()
        values = {name: array[k] for name, array in self._run.arrays.items()}
        for joint, name in self._frames.items():
            _add_transform(message, name, kin.pin_data.oMi[joint], t)
        for body in self._setup.scene.bodies:
            T = body_pose(self._setup, body, kin, values)
            _add_transform(message, body.name, T, t)
        return message

    def _joints(self, k: int, t: int) -> JointStates:
        message, run, robot = JointStates(), self._run, self._robot
        stamp(message, t)
        q, v = run["q"][k, robot.nq_base :], run["v"][k, robot.nv_base :]
        tau = run["tau"][k] if "tau" in run else np.full(robot.na, np.nan)
        for name, position, velocity, effort in zip(
            robot.joint_names, q.tolist(), v.tolist(), tau.tolist(), strict=True
        ):
            message.joints.add(name=name, position=position, velocity=velocity, effort=effort)
        return message

    def _forces(self, kin: Kinematics, k: int, t: int) -> SceneUpdate:
        values = {name: array[k] for name, array in self._run.arrays.items()}
        arrows, update = self._arrows.at(kin, values), SceneUpdate()
        for name, found, rgb in (
            ("measured", arrows.measured, MEASURED_RGB),
            ("wanted", arrows.wanted, WANTED_RGB),
        ):
            entity = _entity(update, name, WORLD, t)
            for arrow in found:
                add_arrow(entity, arrow, rgb)
        return update


def _ticks(run: Run, rate: float) -> Indices:
    """Return the ticks that pictures are made of: the first, and then `rate` a second."""
    count = int((run.t[-1] - run.t[0]) * rate) + 1
    wanted = run.t[0] + np.arange(count) / rate
    ticks = np.unique(np.searchsorted(run.t, wanted - 1e-9).clip(0, len(run.t) - 1))
    return ticks[np.isfinite(run["q"][ticks]).all(axis=1)]


def _link_names(model: pin.Model) -> dict[int, str]:
    """Return for each joint the name of its first link, and of the world's."""
    names = {0: "world_link"}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY and frame.parentJoint > 0:
            names.setdefault(frame.parentJoint, frame.name)
    for joint in range(1, model.njoints):
        names.setdefault(joint, model.names[joint])
    return names


def _entity(update: SceneUpdate, name: str, frame: str, t: int) -> SceneEntity:
    entity = update.entities.add(id=name, frame_id=frame, frame_locked=True)
    stamp(entity, t)
    return entity


def _add_transform(message: FrameTransforms, name: str, T: pin.SE3, t: int) -> None:
    made = message.transforms.add(parent_frame_id=WORLD, child_frame_id=name)
    stamp(made, t)
    numbers: Array = pin.SE3ToXYZQUAT(T)
    at, turn = made.translation, made.rotation
    at.x, at.y, at.z = (float(x) for x in numbers[:3])
    turn.x, turn.y, turn.z, turn.w = (float(x) for x in numbers[3:])
