"""What there is to see at a tick of a run: robot, world where it is, forces as arrows."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin

from equipoise.analysis.rendering.body_poses import body_pose, carrier_of
from equipoise.analysis.rendering.force_arrows import ForceArrows
from equipoise.analysis.rendering.part import Part
from equipoise.analysis.rendering.scene_meshes import Picture, join_parts, robot_parts, shape_parts
from equipoise.analysis.rendering.stands import stands
from equipoise.analysis.rendering.tessellation import Mesh, tessellate
from equipoise.analysis.run_context import RunContext
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.spatial import Array, Indices

MEASURED, WANTED = np.array([0.84, 0.16, 0.16]), np.array([1.0, 0.62, 0.0])
SHAFT, HEAD, HEAD_LENGTH = 0.008, 0.02, 0.045  # [m] radii, and length of the head
SHORTEST = 0.004  # [m]


class RunPictures:
    """Makes the picture of every tick of a run; `arrows` says whether forces are shown."""

    def __init__(self, context: RunContext, *, arrows: bool = True) -> None:
        self.run, self.setup = context.run, context.setup
        setup, scene = self.setup, self.setup.scene
        self._evaluator = KinematicsEvaluator(setup.robot)
        self._forces = ForceArrows(setup) if arrows else None
        self._robot = robot_parts(setup.robot)
        self._stands = stands(scene, frozenset(setup.sliders))
        self._bodies: list[tuple[int, list[Part]]] = []
        for number, body in enumerate(scene.bodies):
            _, T_joint_body = carrier_of(setup, body)
            shapes = [scene.geometry.geometryObjects[i] for i in scene.shapes_of(body.name)]
            own = [
                Part(0, part.mesh.moved(T_joint_body.inverse()), part.rgb)
                for part in shape_parts(shapes)
            ]
            self._bodies.append((number, own))

    @property
    def ticks(self) -> Indices:
        """The ticks of which a picture can be made."""
        return np.flatnonzero(np.isfinite(self.run["q"]).all(axis=1))

    def kinematics(self, tick: int) -> Kinematics:
        """Return the robot's state at a tick, at rest."""
        return self._evaluator.at(self.run["q"][tick], np.zeros(self.setup.robot.nv))

    def at(self, tick: int) -> Picture:
        """Return the picture of a tick."""
        kin = self.kinematics(tick)
        values = {name: array[tick] for name, array in self.run.arrays.items()}
        placed = [(part.mesh.moved(kin.pin_data.oMi[part.joint]), part.rgb) for part in self._robot]
        placed += [(part.mesh, part.rgb) for part in self._stands]
        for number, parts in self._bodies:
            T = body_pose(self.setup, self.setup.scene.bodies[number], kin, values)
            placed += [(part.mesh.moved(T), part.rgb) for part in parts]
        if self._forces is not None:
            arrows = self._forces.at(kin, values)
            placed += [(mesh, MEASURED) for arrow in arrows.measured for mesh in arrow_mesh(arrow)]
            placed += [(mesh, WANTED) for arrow in arrows.wanted for mesh in arrow_mesh(arrow)]
        return join_parts(placed)

    def still_points(self) -> Array:
        """Return corners (n, 3) of what is fixed in the world."""
        fixed = [part.mesh.vertices for part in self._stands]
        for number, parts in self._bodies:
            body = self.setup.scene.bodies[number]
            if body.frame is None:
                fixed += [part.mesh.moved(body.T_parent_body).vertices for part in parts]
        return np.vstack([np.empty((0, 3)), *fixed])

    def robot_points(self, tick: int) -> Array:
        """Return corners (n, 3) of the robot at a tick, a part of them."""
        kin = self.kinematics(tick)
        return np.vstack(
            [part.mesh.moved(kin.pin_data.oMi[part.joint]).vertices[::7] for part in self._robot]
        )


def arrow_mesh(arrow: Array) -> list[Mesh]:
    """Return shaft and head of an arrow (2, 3) [m] from tail to tip; nothing without length."""
    way = arrow[1] - arrow[0]
    length = float(np.linalg.norm(way))
    if not length > SHORTEST:
        return []
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), way / length)
    rotation, head = turn.toRotationMatrix(), min(HEAD_LENGTH, length)
    shapes = [(coal.Cone(HEAD, head), length - 0.5 * head)]
    if length - head > SHORTEST:
        shapes.append((coal.Cylinder(SHAFT, length - head), 0.5 * (length - head)))
    found = []
    for shape, middle in shapes:
        mesh = tessellate(shape, 12)
        if mesh is not None:
            found.append(mesh.moved(pin.SE3(rotation, arrow[0] + middle * way / length)))
    return found
