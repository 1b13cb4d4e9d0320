"""No name of a user's can meet one of ours, or another of the user's, in a generated model."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from equipoise.collision.scene import Body, Shape
from equipoise.contacts import ContactStack, SoleContact, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.robots import Robot, load_robot, robot_urdf_path
from equipoise.spatial import pose
from helpers import kinematics

pytest.importorskip("mujoco")

from equipoise.physics.mujoco import LooseObject, MujocoEngine, Surroundings
from equipoise.physics.mujoco.names import in_model, of_joint, of_object

PLAIN = ("one", "two", "three", "four", "five", "six", "seven", "eight")
HOSTILE = ("base", "floor", "world", "robot", "pad_12", "object/base", "robot/base", "link/0")


def test_different_things_have_different_names():
    names = [make(free) for make in (of_joint, of_object) for free in HOSTILE]
    for kind in ("sole", "ball", "surface"):
        names += [in_model(kind, free) for free in HOSTILE]
        names += [in_model(f"{kind}_shape", free, k) for free in HOSTILE for k in range(12)]
    assert all(a != b for a, b in combinations((*names, "robot", "floor", "world"), 2))


def test_hostile_names_give_the_same_motion_to_the_bit(tmp_path):
    states = []
    for k, names in enumerate((PLAIN, HOSTILE)):
        engine = _engine(_renamed(tmp_path / str(k), names), names)
        tau = engine.stand()
        states.append([engine.step(tau) for _ in range(20)][-1])
        found = [engine.object_pose(name).translation for name in names]
        assert [p[2] for p in found] == sorted(p[2] for p in found)
    for plain, hostile in zip(*states, strict=True):
        assert np.array_equal(plain, hostile)


def _renamed(folder: Path, names: tuple[str, ...]) -> Robot:
    """Return HRP-2 with its first joints renamed."""
    folder.mkdir()
    source = Path(robot_urdf_path("hrp2"))
    joints = [name for name in re.findall(r'joint name="(\w+JOINT\d)"', source.read_text())]
    for path in (source.with_suffix(end) for end in (".urdf", ".srdf", ".yaml")):
        text = path.read_text()
        for old, new in zip(joints, names, strict=False):
            text = re.sub(rf"\b{old}\b", new, text)
        (folder / path.name).write_text(text)
    return load_robot(folder / source.name)


def _engine(robot: Robot, names: tuple[str, ...]) -> MujocoEngine:
    """Return the robot on its soles with a palm on a wall, among blocks and boxes, all so named."""
    q = robot.q_half_sitting
    kin = kinematics(robot, q)
    soles = [SoleContact.standing(s, kin, name=n) for s, n in zip(robot.soles, names, strict=False)]
    palm = robot.frame_id("right_palm")
    wall = SurfaceContact(
        name=names[2],
        frame=palm,
        surface=Plane(),
        T_world_surface=kin.placement(palm) * pose((0.0, 0.0, 0.0), (np.pi, 0.0, 0.0)),
    )
    places = [
        pin.SE3(np.eye(3), np.array([3.0, 0.5 * k, 0.3 * k + 1.0])) for k in range(len(names))
    ]
    box = (Shape("box", (0.1, 0.1, 0.1), pose((0, 0, 0))),)
    loose = [LooseObject(Body(n, box, T), 1.0, 0.5, T) for n, T in zip(names, places, strict=True)]
    fixed = [Body(n, box, pose((-3.0, 0.5 * k, 0.0))) for k, n in enumerate(names)]
    return MujocoEngine(
        robot,
        ContactStack([*soles, wall]),
        q,
        1e-3,
        surroundings=Surroundings(fixed=tuple(fixed), loose=tuple(loose)),
    )
