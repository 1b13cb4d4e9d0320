"""What a page needs to play a run: meshes of rigid nodes, their poses over time, force lines."""

from __future__ import annotations

import base64
import hashlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.analysis.rendering.part import Part
from equipoise.analysis.rendering.scene_meshes import robot_parts
from equipoise.analysis.rendering.sole_arrows import outer_sides, sole_arrow, sole_contacts
from equipoise.analysis.rendering.stands import stands
from equipoise.analysis.rendering.tessellation import tessellate
from equipoise.runlog import Run
from equipoise.scenarios import schema
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import POSE_SIZE, Array, Indices

RATE = 25.0  # [Hz]
MOST_FRAMES = 1500
HEAD = 0.03  # [m]


@dataclass
class Blobs:
    """Arrays as base64 text, each kept once however often it is used."""

    texts: dict[str, str] = field(default_factory=dict)

    def add(self, array: np.ndarray) -> str:
        """Keep an array and return its name."""
        content = np.ascontiguousarray(array).tobytes()
        name = hashlib.sha1(content, usedforsecurity=False).hexdigest()[:16]
        self.texts.setdefault(name, base64.b64encode(content).decode())
        return name


def export_replay(
    run: Run, scenario: schema.Scenario, setup: Setup, blobs: Blobs
) -> dict[str, Any] | None:
    """Return the run as the page's script reads it; None without a finite tick.

    Nodes are the joints, then the sliders. Poses are x, y, z [m] and a quaternion xyzw.
    """
    chosen = _frames(run)
    if not len(chosen):
        return None
    sliders = list(scenario.world.sliders)
    parts = _parts(setup, sliders)
    poses = _poses(run, chosen, scenario, setup, sliders)
    sides = outer_sides(setup)
    lines = np.array([_force_lines(run, k, setup, sides) for k in chosen], dtype=np.float32)
    return {
        "nodes": poses.shape[1],
        "segments": lines.shape[1] if lines.ndim == 4 else 0,
        "times": blobs.add(run.t[chosen].astype(np.float32)),
        "poses": blobs.add(poses),
        "lines": blobs.add(lines),
        "meshes": [_mesh(node, rgb, same, blobs) for (node, rgb), same in parts.items()],
    }


Key = tuple[int, tuple[float, float, float]]


def _frames(run: Run) -> Indices:
    """Return the ticks to show: every 1/RATE s, fewer of a long run, only finite ones."""
    if not run.t.size:
        return np.zeros(0, dtype=int)
    span = float(run.t[-1] - run.t[0])
    count = int(min(MOST_FRAMES, max(1, round(span * RATE)))) + 1
    wanted = np.linspace(run.t[0], run.t[-1], count)
    chosen = np.unique(np.searchsorted(run.t, wanted).clip(0, len(run.t) - 1))
    return chosen[np.isfinite(run["q"][chosen]).all(axis=1)]


def _parts(setup: Setup, sliders: list[str]) -> dict[Key, list[Part]]:
    groups: dict[Key, list[Part]] = {}
    moving = frozenset(setup.sliders)
    for part in (*robot_parts(setup.robot), *stands(setup.scene, moving)):
        groups.setdefault((part.joint, _colour(part.rgb)), []).append(part)
    scene, joints = setup.scene, setup.robot.model.njoints
    for body in scene.bodies:
        for index in scene.shapes_of(body.name):
            shape = scene.geometry.geometryObjects[index]
            mesh = tessellate(shape.geometry)
            if mesh is None:
                continue
            node = shape.parentJoint
            if body.name in sliders:
                node = joints + sliders.index(body.name)
            part = Part(node, mesh.moved(shape.placement), np.asarray(shape.meshColor)[:3])
            groups.setdefault((node, _colour(part.rgb)), []).append(part)
    return groups


def _colour(rgb: Array) -> tuple[float, float, float]:
    red, green, blue = (round(float(c), 3) for c in np.clip(rgb, 0.0, 1.0))
    return red, green, blue


def _mesh(
    node: int, rgb: tuple[float, float, float], parts: list[Part], blobs: Blobs
) -> dict[str, Any]:
    starts = np.cumsum([0, *(len(part.mesh.vertices) for part in parts)])
    triangles = np.vstack(
        [part.mesh.triangles + start for part, start in zip(parts, starts, strict=False)]
    )
    normals = np.vstack([part.mesh.normals for part in parts])
    padded = np.zeros((len(normals), 4), dtype=np.int8)
    padded[:, :3] = np.round(127.0 * normals)
    return {
        "node": node,
        "rgb": list(rgb),
        "count": int(triangles.size),
        "places": blobs.add(np.vstack([part.mesh.vertices for part in parts]).astype(np.float32)),
        "normals": blobs.add(padded),
        "triangles": blobs.add(triangles.astype(np.uint32)),
    }


def _poses(
    run: Run, chosen: Indices, scenario: schema.Scenario, setup: Setup, sliders: list[str]
) -> np.ndarray:
    model = setup.robot.model
    data = model.createData()
    poses = np.zeros((len(chosen), model.njoints + len(sliders), POSE_SIZE), dtype=np.float32)
    poses[:, :, 6] = 1.0
    for i, k in enumerate(chosen):
        pin.forwardKinematics(model, data, np.array(run["q"][k]))
        for joint in range(1, model.njoints):
            poses[i, joint] = pin.SE3ToXYZQUAT(data.oMi[joint])
    for j, name in enumerate(sliders):
        if f"slider/{name}" in run:
            direction = np.array(scenario.world.sliders[name].direction)
            travel = run[f"slider/{name}"][chosen, 0]
            poses[:, model.njoints + j, :3] = travel[:, None] * direction
    return poses


def _force_lines(run: Run, k: int, setup: Setup, sides: dict[str, float]) -> list[Array]:
    """Return the lines (2, 3) [m] of each sole's arrow, without length where there is no force."""
    lines: list[Array] = []
    kin = setup.robot.at(run["q"][k])
    for contact in sole_contacts(setup):
        if f"lam/{contact.name}" in run:
            arrow = sole_arrow(contact, kin, run[f"lam/{contact.name}"][k], sides[contact.name])
            across = kin.placement(contact.sole.frame).rotation[:, 1]
            lines += [np.zeros((2, 3))] * 3 if arrow is None else _with_head(arrow, across)
    return lines


def _with_head(arrow: Array, across: Array) -> list[Array]:
    """Return an arrow (2, 3) [m] as three lines: its shaft and two barbs, one on either side."""
    tail, tip = arrow
    back = min(HEAD, np.linalg.norm(tip - tail)) * (tail - tip) / np.linalg.norm(tip - tail)
    aside = 0.4 * np.linalg.norm(back) * across
    return [arrow, np.array([tip, tip + back + aside]), np.array([tip, tip + back - aside])]
