"""From what the sensors behind the pads read to the multipliers of the contacts' own rows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.scratch import scratch
from equipoise.compiled.workspace import (
    Arrays,
    Block,
    Workspace,
    integer_matrix,
    integers,
    matrix,
    part_of,
    vector,
)
from equipoise.contacts import (
    Contact,
    ContactStack,
    GraspContact,
    MovingSurfaceContact,
    PointContact,
    SoleContact,
    SurfaceContact,
)
from equipoise.contacts.surfaces import Plane
from equipoise.errors import NameNotFoundError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.kinematics.kernels import FRAMES, Q, place_frames, place_joints, state_of
from equipoise.kinematics.tree import fill_tree, tree_of
from equipoise.physics.mujoco.contact_pads import PadSensor, frames_of
from equipoise.robots import Robot
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import crossed, rotation_difference, turned_back

SOLE, GRASP, NORMAL, POINT = range(4)
ARRAYS = Arrays(
    (
        *("lam", "violation", "wrenches", "sites", "sensors"),
        *("anchors", "normals", "kinds", "pads", "rows", "supports"),
    ),
    frozenset({"sites", "sensors", "kinds", "pads", "rows", "supports"}),
)
LAM, VIOLATION, WRENCHES, SITES, SENSORS = range(5)
ANCHORS, NORMALS, KINDS, PADS, ROWS, SUPPORTS = range(5, 11)


class ContactForces:
    """Reads `lam` (r,), world on robot, and `violation` [m or rad]: how far supports have moved.

    Pads stand in the order of `sensors`, contacts in that of the stack.
    """

    def __init__(
        self,
        robot: Robot,
        contacts: ContactStack,
        compiled_model: Any,
        sensors: tuple[PadSensor, ...],
    ) -> None:
        self._robot, self._contacts = robot, contacts
        self._evaluator = KinematicsEvaluator(robot)
        self._sliding: list[tuple[int, SurfaceContact | MovingSurfaceContact]] = []
        self._other_supports: list[Contact] = []  # those whose residual only they know
        self._memory = _memory(robot, [sensor.frame_id for sensor in sensors], contacts)
        part = self._memory.contacts
        self._normals = part.normals
        self.lam, self._violation = part.lam, part.violation
        for k, sensor in enumerate(sensors):
            part.sites[k] = compiled_model.site(sensor.site).id
            part.sensors[k] = [
                compiled_model.sensor(name).adr[0] for name in (sensor.force, sensor.torque)
            ]
        self.violation = 0.0
        self._describe_contacts([sensor.frame_id for sensor in sensors])

    def _describe_contacts(self, frames: list[int]) -> None:
        part, contacts = self._memory.contacts, self._contacts
        for k, contact in enumerate(contacts.contacts):
            touched = frames_of(self._robot, contact)
            part.pads[k] = frames.index(touched[0]), frames.index(touched[-1])
            part.rows[k] = contacts.rows[contact.name].start
            if isinstance(contact, SoleContact):
                part.kinds[k], part.anchors[k] = SOLE, pose_row(contact.T_world_anchor)
                part.supports[k] = contact.supporting
            else:
                part.kinds[k] = GRASP if isinstance(contact, GraspContact) else NORMAL
                if isinstance(contact, PointContact):
                    part.kinds[k] = POINT
                if contact.supporting:
                    self._other_supports.append(contact)
            if isinstance(contact, SurfaceContact) and isinstance(contact.surface, Plane):
                self._normals[k] = contact.T_world_surface.rotation[:, 2]  # wherever it is touched
            elif isinstance(contact, SurfaceContact | MovingSurfaceContact):
                self._sliding.append((k, contact))

    def anchor(self, name: str, T_world_anchor: pin.SE3 | None) -> None:
        """Read a sole from another place on, or as one in the air. Raises: `NameNotFoundError`."""
        names = [one.name for one in self._contacts.contacts if isinstance(one, SoleContact)]
        if name not in names:
            raise NameNotFoundError("sole contact", name, names)
        k = next(k for k, one in enumerate(self._contacts.contacts) if one.name == name)
        part = self._memory.contacts
        part.supports[k] = T_world_anchor is not None
        if T_world_anchor is not None:
            part.anchors[k] = pose_row(T_world_anchor)

    def read(self, q: Array, v: Array, t: float, readings: Array, xmat: Array) -> None:
        """Take the mean of the sensors into `lam`, in the rows of the state reached.

        `xmat` (nsite, 9) are MuJoCo's axes of the sites.
        """
        memory, far = self._memory, 0.0
        if self._sliding or self._other_supports:
            kin = self._evaluator.at(q, v, t)
            for k, contact in self._sliding:
                self._normals[k] = contact.normal(kin)
            for support in self._other_supports:
                far = max(far, float(np.abs(support.residual(kin)).max()))
        read_contacts(memory.floats, memory.integers, memory.tables, q, readings, xmat)
        self.violation = max(far, float(self._violation[0]))


def _memory(robot: Robot, frames: list[int], contacts: ContactStack) -> Workspace:
    count, pads = len(contacts.contacts), len(frames)
    shapes = ARRAYS.shapes(
        lam=contacts.size,
        violation=1,
        wrenches=(pads, 6),
        sites=pads,
        sensors=(pads, 2),
        anchors=(count, 12),
        normals=(count, 3),
        kinds=count,
        pads=(count, 2),
        rows=count,
        supports=count,
    )
    memory = Workspace(
        {
            "tree": tree_of(robot.model, frames),
            "state": state_of(robot.model, pads),
            "contacts": shapes,
        }
    )
    fill_tree(memory.tree, robot.model, frames)
    return memory


@entrance
def read_contacts(
    floats: np.ndarray,
    whole: np.ndarray,
    tables: np.ndarray,
    q: np.ndarray,
    readings: np.ndarray,
    xmat: np.ndarray,
) -> None:
    """Write `lam` and the violation at q [nq] from the sensors; frames are those of the pads."""
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1)
    part, own = part_of(floats, whole, tables, 2), vector(state, Q)
    for i in range(own.shape[0]):
        own[i] = q[i]
    place_joints(tree, state)
    place_frames(tree, state)
    read_pads(part, readings, xmat)
    kinds, pads, rows = integers(part, KINDS), integer_matrix(part, PADS), integers(part, ROWS)
    wrenches, anchors = matrix(part, WRENCHES), matrix(part, ANCHORS)
    placements, normals = matrix(state, FRAMES), matrix(part, NORMALS)
    supports, lam, violation = integers(part, SUPPORTS), vector(part, LAM), vector(part, VIOLATION)
    violation[0] = 0.0
    for k in range(kinds.shape[0]):
        a, b, at = pads[k, 0], pads[k, 1], rows[k]
        if kinds[k] == SOLE:
            turn_wrench(anchors[k], wrenches[a], lam, at)
            if supports[k]:
                violation[0] = max(violation[0], gap(placements[a], anchors[k]))
        elif kinds[k] == GRASP:
            squeeze(placements[a], placements[b], wrenches[a], wrenches[b], lam, at)
        elif kinds[k] == POINT:
            lam[at], lam[at + 1], lam[at + 2] = wrenches[a, 0], wrenches[a, 1], wrenches[a, 2]
        else:
            n, w = normals[k], wrenches[a]
            lam[at] = n[0] * w[0] + n[1] * w[1] + n[2] * w[2]


@compiled
def read_pads(part: Block, readings: np.ndarray, xmat: np.ndarray) -> None:
    """Write the wrench of the world on each pad, in world axes.

    MuJoCo reads what the link does to the pad; the world does the opposite to it.
    """
    wrenches, site = matrix(part, WRENCHES), integers(part, SITES)
    sensor = integer_matrix(part, SENSORS)
    for k in range(site.shape[0]):
        R, wrench = xmat[site[k]], wrenches[k]
        for half in range(2):
            at = sensor[k, half]
            for i in range(3):
                total = 0.0
                for j in range(3):
                    total += R[3 * i + j] * readings[at + j]
                wrench[3 * half + i] = -total


@compiled
def turn_wrench(T: np.ndarray, wrench: np.ndarray, lam: np.ndarray, at: int) -> None:
    """Write a wrench [6] in the axes of T [12] to lam from `at` on."""
    lam[at], lam[at + 1], lam[at + 2] = turned_back(T, wrench[0], wrench[1], wrench[2])
    lam[at + 3], lam[at + 4], lam[at + 5] = turned_back(T, wrench[3], wrench[4], wrench[5])


@compiled
def gap(T: np.ndarray, anchor: np.ndarray) -> float:
    """Return the largest component [m or rad] of how far T is from its anchor, in its axes."""
    x, y, z = turned_back(anchor, T[9] - anchor[9], T[10] - anchor[10], T[11] - anchor[11])
    rx, ry, rz = rotation_difference(T, anchor)
    rx, ry, rz = turned_back(anchor, rx, ry, rz)
    return max(abs(x), abs(y), abs(z), abs(rx), abs(ry), abs(rz))


@compiled
def squeeze(
    T_a: np.ndarray,
    T_b: np.ndarray,
    at_a: np.ndarray,
    at_b: np.ndarray,
    lam: np.ndarray,
    row: int,
) -> None:
    """Write half the difference of what the object does to b and to a: its weight drops out.

    Both are taken at the origin of b and in the axes of a.
    """
    x, y, z = crossed(
        T_a[9] - T_b[9], T_a[10] - T_b[10], T_a[11] - T_b[11], at_a[0], at_a[1], at_a[2]
    )
    half = scratch(6)
    for i in range(6):
        half[i] = 0.5 * (at_b[i] - at_a[i])
    half[3] -= 0.5 * x
    half[4] -= 0.5 * y
    half[5] -= 0.5 * z
    turn_wrench(T_a, half, lam, row)
