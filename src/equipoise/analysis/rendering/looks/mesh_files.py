"""The mesh files that a URDF names as its robot's look, where our model has simpler shapes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from equipoise.robots.files.description import Node, read_description
from equipoise.robots.files.meshes import MeshFolders
from equipoise.robots.files.values import Report
from equipoise.robots.robot import Robot
from equipoise.spatial import Array

GREY = (0.62, 0.64, 0.67)


@dataclass(frozen=True)
class MeshFile:
    """A mesh file on a link: where it stands in the link's axes, its scale (3,), its colour."""

    link: str
    path: Path
    placement: pin.SE3
    scale: Array
    rgb: Array


def mesh_files(robot: Robot) -> list[MeshFile]:
    """Return the visual meshes in the robot's URDF that can be found, by the links of the model.

    Raises: RobotFileError if the URDF can no longer be read.
    """
    if robot.urdf_path.suffix.lower() != ".urdf":
        return []
    tree = read_description(robot.urdf_path)
    folders, report = MeshFolders(robot.urdf_path), Report()
    colours = {
        node.get("name", ""): rgb
        for node in tree.findall("material")
        if (rgb := _rgb(node)) is not None
    }
    links = {frame.name for frame in robot.model.frames if frame.type == pin.FrameType.BODY}
    found = []
    for link in tree.findall("link"):
        name = link.get("name", "")
        if name not in links:
            continue
        for visual in link.findall("visual"):
            for mesh in visual.iter("mesh"):
                clean = folders.checked(report, mesh, name)
                if clean is not None:
                    found.append(_described(name, visual, clean, colours))
    return found


def _described(link: str, visual: Node, mesh: Node, colours: dict[str, Array]) -> MeshFile:
    origin = visual.find("origin")
    xyz = _numbers(origin, "xyz")
    placement = pin.SE3(pin.rpy.rpyToMatrix(_numbers(origin, "rpy")), xyz)
    path = Path(mesh.get("filename", ""))
    scale = np.array([float(x) for x in mesh.get("scale", "1 1 1").split()])
    material = visual.find("material")
    own = None if material is None else _rgb(material)
    if own is None and material is not None:
        own = colours.get(material.get("name", ""))
    if path.suffix.lower() == ".dae":  # paints itself
        own = _colour_of_dae(path)
    return MeshFile(link, path, placement, scale, np.array(GREY) if own is None else own)


def _numbers(origin: Node | None, key: str) -> Array:
    text = "0 0 0" if origin is None else origin.get(key, "0 0 0")
    return np.array([float(x) for x in text.split()])


def _rgb(material: Node) -> Array | None:
    colour = material.find("color")
    if colour is None:
        return None
    return np.clip([float(x) for x in colour.get("rgba", "").split()[:3]], 0.0, 1.0)


def _colour_of_dae(path: Path) -> Array | None:
    """Return the lightest of the plain colours that a COLLADA file paints with."""
    colours = list(_diffuse(path.read_bytes()))
    return max(colours, key=lambda rgb: float(rgb.sum())) if colours else None


def _diffuse(content: bytes) -> Iterator[Array]:
    for found in re.finditer(rb"<diffuse>\s*<color[^>]*>([^<]{1,200})</color>", content):
        numbers = np.array([float(x) for x in found[1].split()])
        if numbers.size >= 3 and np.isfinite(numbers).all():
            yield np.clip(numbers[:3], 0.0, 1.0)
