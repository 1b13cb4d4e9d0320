"""Projection of the centre of mass stays inside the support polygon: one inequality an edge."""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled
from equipoise.compiled.workspace import matrix, vector
from equipoise.contacts import SupportPolygon
from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import COM, COM_ROWS
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, real_number
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask, require_rate
from equipoise.tasks.view import COM_POLYGON, TaskView

GRAVITY = 9.81  # [m/s^2]

# entries of the numbers: height of the floor [m]; whether the polygon leans, and its margin [m];
# how far it leans (x, y) [m], and which share of the weight hands lift; then three an edge
HEIGHT, LEANS, MARGIN, LEAN_X, LEAN_Y, LIFTED, EDGES = range(7)


@compiled
def com_rows(task: TaskView) -> None:
    """Write `n . J_com v <= rate * room` for each edge, with the room of `room_at`."""
    com, J_com, numbers = vector(task.state, COM), matrix(task.state, COM_ROWS), task.numbers
    A, at, lean = task.A, task.at, numbers[LEAN_X : LIFTED + 1]
    for i in range((numbers.shape[0] - EDGES) // 3):
        nx, ny = numbers[EDGES + 3 * i], numbers[EDGES + 3 * i + 1]
        for c in range(J_com.shape[1]):
            A[at + i, c] = nx * J_com[0, c] + ny * J_com[1, c]
        task.lower[at + i] = -np.inf
        task.upper[at + i] = task.rate * room_at(numbers, i, com, lean)


@compiled
def room_at(numbers: np.ndarray, i: int, com: np.ndarray, lean: np.ndarray) -> float:
    """Return how far the centre of mass is inside edge i, moved in, where hands give `lean` [3].

    With forces F and moments M about the floor's origin that hands give the robot, the point of
    zero moment is at `z = (c + (M_y, -M_x) / mg) / (1 - F_z / mg)`; so `n . z <= o` is
    `n . c <= o (1 - lifted) + n . lean` with `lean = (-M_y, M_x) / mg` and `lifted = F_z / mg`.
    """
    nx, ny = numbers[EDGES + 3 * i], numbers[EDGES + 3 * i + 1]
    offset = numbers[EDGES + 3 * i + 2] * (1.0 - lean[2])
    return offset + nx * (lean[0] - com[0]) + ny * (lean[1] - com[1])


class ComPolygonTask(KernelTask):
    """Bound the speed of the centre of mass toward each edge by its distance to it.

    `n . J_com v <= rate * (distance to the edge - margin)`: the edge minus `margin` [m] is
    approached exponentially and not crossed while `rate * dt <= 1`; outside, it is returned to.
    A centre of mass that comes to an edge brakes with `rate^2` times its distance; a floor that
    can only push gives `g/h` times it at a height h, so a rate above `sqrt(g/h)` is warned of.
    With `leans` a `WholeBodyController` moves the polygon with what hands are wanted to press: the
    robot leans into it, on a floor at the `height` [m], and a force waits until it is borne. How
    fast it leans depends on the margin.
    Source: section V (Sugihara and Nakamura 2002 for the Jacobian); the moment that hands give as
    in Audren et al. 2014 for the zero-moment point.
    Raises: `InputError`.
    """

    row_unit = "m/s"
    kind = COM_POLYGON
    alone = staticmethod(alone_of("com", com_rows))

    def __init__(
        self,
        name: str,
        polygon: SupportPolygon,
        *,
        margin: float = 0.02,
        rate: float = 3.0,
        leans: bool = False,
        height: float = 0.0,
    ) -> None:
        super().__init__(name)
        require_kind(f"whether task {name!r} leans", leans, bool)
        self.leans = leans
        self.height = real_number(f"the height of the floor of task {name!r}", height)
        self.polygon, self.margin = polygon, require_margin(name, polygon, margin)
        self.rate = require_rate(name, rate)
        self._labels = tuple(f"edge{i}" for i in range(len(polygon.offsets)))

    @property
    def labels(self) -> tuple[str, ...]:
        """One edge a row."""
        return self._labels

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",) * len(self.polygon.offsets)

    @property
    def numbers(self) -> Array:
        """Height, lean and margin; of each edge, moved in by the margin, normal (2) and offset."""
        edges = np.column_stack((self.polygon.normals, self.polygon.offsets - self.margin))
        begin = [self.height, float(self.leans), self.margin, 0.0, 0.0, 0.0]
        return np.concatenate((begin, edges.ravel()))

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] the centre of mass is beyond each edge moved in, nothing pressed."""
        edges = self.polygon
        inside = edges.offsets - edges.normals @ kin.p_world_com[:2]
        return np.maximum(0.0, self.margin - inside)

    def advice(self, robot: Robot, kin: Kinematics) -> tuple[str, ...]:
        """Return a sentence if a floor cannot brake the robot as fast as the rate wants."""
        floors = [kin.placement(sole.frame).translation[2] for sole in robot.soles]
        height = float(kin.p_world_com[2]) - min(floors, default=0.0)
        if not height > 0.0 or self.rate <= np.sqrt(GRAVITY / height):
            return ()
        return (
            f"task {self.name!r} has a rate of {self.rate:g} 1/s, above sqrt(g/h) = "
            f"{np.sqrt(GRAVITY / height):.2f} 1/s with the centre of mass at h = {height:.2f} m: "
            "a floor cannot brake the robot so late, a sole would have to pull. "
            f"Give it a rate of at most {np.floor(10.0 * np.sqrt(GRAVITY / height)) / 10.0:g} 1/s.",
        )

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return tuple(
            RowDescription.both(f"the {label} of the support polygon", "m/s", self.rate)
            for label in block.labels
        )


def require_margin(name: str, polygon: SupportPolygon, margin: float) -> float:
    """Return a margin [m] that leaves something of a polygon. Raises: `InputError`."""
    require_kind(f"the polygon of task {name!r}", polygon, SupportPolygon)
    margin = not_negative(f"the margin of task {name!r}", margin, "m")
    if not polygon.holds_margin(margin):
        raise InputError(
            f"the margin of task {name!r} leaves nothing of the support polygon",
            given=margin,
            remedy=f"Give metres; its corners are {polygon.vertices.round(3).tolist()}",
        )
    return margin
