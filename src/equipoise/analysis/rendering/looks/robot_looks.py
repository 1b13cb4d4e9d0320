"""From a robot to the parts that are drawn: our shells, its mesh files, or none of both."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.analysis.rendering.looks import hrp2
from equipoise.analysis.rendering.looks.keep import meshes_of
from equipoise.analysis.rendering.looks.mesh_files import mesh_files
from equipoise.analysis.rendering.part import Part
from equipoise.analysis.rendering.tessellation import Mesh
from equipoise.errors import RobotFileError
from equipoise.robots.hulls import is_mesh
from equipoise.robots.registry import robot_urdf_path
from equipoise.robots.robot import Robot

MOST_TRIANGLES = 36_000  # of a whole robot


def looks_of(robot: Robot) -> list[Part]:
    """Return what a robot looks like beyond its own shapes; nothing if they are all there is.

    Meshes that its URDF names are taken where the robot's YAML put simple shapes in their place.
    """
    if robot.urdf_path == robot_urdf_path("hrp2").resolve():
        return [part for shell in hrp2.shells() for part in _placed(robot, *shell)]
    if any(is_mesh(shape.geometry) for shape in robot.visual_model.geometryObjects):
        return []
    try:
        files = mesh_files(robot)
    except RobotFileError:
        return []
    meshes = meshes_of(files, MOST_TRIANGLES)
    return [
        part
        for file, mesh in zip(files, meshes, strict=True)
        if len(mesh.triangles)
        for part in _placed(robot, file.link, mesh.moved(file.placement), file.rgb)
    ]


def _placed(robot: Robot, link: str, mesh: Mesh, rgb: np.ndarray) -> list[Part]:
    """Return the mesh in the axes of the joint that carries the link, if the robot has that."""
    if not robot.model.existFrame(link, pin.FrameType.BODY):
        return []
    frame = robot.model.frames[robot.model.getFrameId(link, pin.FrameType.BODY)]
    return [Part(frame.parentJoint, mesh.moved(frame.placement), rgb)]
