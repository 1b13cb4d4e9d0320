"""A floor that can only push: the momentum may change only as it allows, an inequality an edge."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import integers, vector
from equipoise.contacts import SupportPolygon
from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import COM, MOMENTUM_RATE, VELOCITY
from equipoise.kinematics.momentum import momentum_column, weigh_turning
from equipoise.kinematics.tree import BELOW, FIRST_COLUMN, FIRST_V, FOLLOWS, WIDTH
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_number, require_period, share
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask
from equipoise.tasks.com_polygon import GRAVITY, require_margin
from equipoise.tasks.view import FLOOR_SUPPORT, TaskView

# entries of the numbers; from EDGES on three an edge
HEIGHT, LEANS, PERIOD, SCALE, LEAST, LEAN_X, LEAN_Y, LIFTED, EDGES = range(9)


@compiled
def support_rows(task: TaskView) -> None:
    """Write for each edge that the floor's moment about it, and so its push, stays inward."""
    numbers, A, at = task.numbers, task.A, task.at
    v, rate = vector(task.state, VELOCITY), vector(task.state, MOMENTUM_RATE)
    first_v, mass = integers(task.tree, FIRST_V), vector(task.tree, BELOW)[0]
    first, width = integers(task.tree, FIRST_COLUMN), integers(task.tree, WIDTH)
    follows = integers(task.tree, FOLLOWS)
    weight = GRAVITY * mass
    weigh_turning(task.tree, task.state)
    height, dt, scale = numbers[HEIGHT], numbers[PERIOD], numbers[SCALE]
    count, p = (numbers.shape[0] - EDGES) // 3, scratch(6)
    for i in range(count + 1):
        task.lower[at + i], task.upper[at + i] = 0.0, np.inf
    for j in range(1, first_v.shape[0]):
        for k in range(width[j]):
            momentum_column(task.tree, task.state, j, first[j] + k, p)
            c = first_v[j] + k
            if not follows[j]:  # who follows adds to its leader, which stands before it
                A[at : at + count + 1, c] = 0.0
            Lx, Ly = p[3] + height * p[1], p[4] - height * p[0]
            for i in range(count):
                n = numbers[EDGES + 3 * i : EDGES + 3 * i + 3]
                value = scale * (n[2] * p[2] + n[0] * Ly - n[1] * Lx)
                A[at + i, c] += value
                task.lower[at + i] += value * v[c]
            A[at + count, c] += p[2] / mass
            task.lower[at + count] += p[2] / mass * v[c]
    com = vector(task.state, COM)
    Mx = rate[3] + height * rate[1] + weight * (com[1] - numbers[LEAN_Y])
    My = rate[4] - height * rate[0] - weight * (com[0] - numbers[LEAN_X])
    Fz = rate[2] + weight * (1.0 - numbers[LIFTED])
    for i in range(count):
        n = numbers[EDGES + 3 * i : EDGES + 3 * i + 3]
        push = n[2] * Fz + n[0] * My - n[1] * Mx
        task.lower[at + i] -= dt * scale * push
    task.lower[at + count] -= dt * (Fz / mass - numbers[LEAST] * GRAVITY)


class FloorSupportTask(KernelTask):
    """Let the momentum change only as a floor can make it, which pushes and never pulls.

    For each edge of the polygon moved in by `margin` [m], with outward normal n and offset o, the
    floor's vertical forces satisfy `sum f_z (o - n . x) >= 0`: where the point of zero moment is.
    By Newton and Euler that sum is linear in dv/dt, and with `dv = v - v_before` over a `period`
    [s] it is a row in v. Mass, centre and angular momentum are those of the nominal robot; the
    floor is at the `height` [m]. The row is divided by the weight's moment arm, m times the height
    of the centre of mass at half-sitting, so that it is a velocity [m/s]. One more row keeps the
    whole push above `least` times the weight: who is in free fall has no point of zero moment.
    It bounds how the centre of mass may speed up, `ComPolygonTask` where it may be: its margin has
    to be the larger one, or nothing is left to brake with. If it `leans`, what hands are asked to
    press counts.
    Source: Vukobratovic and Borovac 2004 for the point of zero moment; Orin, Goswami and Lee 2013
    for the centroidal momentum.
    Raises: `InputError`.
    """

    row_unit = "m/s"
    kind = FLOOR_SUPPORT
    rate = 0.0
    alone = staticmethod(alone_of("support", support_rows))

    def __init__(
        self,
        name: str,
        robot: Robot,
        polygon: SupportPolygon,
        period: float,
        *,
        height: float = 0.0,
        margin: float = 0.01,
        least: float = 0.3,
        leans: bool = True,
    ) -> None:
        super().__init__(name)
        require_kind(f"whether task {name!r} leans", leans, bool)
        self.leans = leans
        require_robot(f"the robot of task {name!r}", robot)
        self.polygon, self.period = polygon, require_period(period)
        self.height = real_number(f"the height of the floor of task {name!r}", height)
        self.margin = require_margin(name, polygon, margin)
        self.least = share(f"the least push of task {name!r}", least)
        over = float(robot.at(robot.q_half_sitting).p_world_com[2]) - self.height
        if not over > 0.0:
            raise InputError(
                f"the floor of task {name!r} lies above the centre of mass at half-sitting",
                given=height,
                remedy=f"Give metres, below {over + self.height:.3g}",
            )
        self.scale = 1.0 / (robot.mass * over)
        self._labels = (*(f"edge{i}" for i in range(len(polygon.offsets))), "push")

    @property
    def labels(self) -> tuple[str, ...]:
        """One edge a row, and the whole push."""
        return self._labels

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",) * len(self._labels)

    @property
    def needs_before(self) -> bool:
        """Whether its rows depend on the velocity of the tick before: they do."""
        return True

    @property
    def numbers(self) -> Array:
        """What the kernel needs, in the order of its entries."""
        edges = np.column_stack((self.polygon.normals, self.polygon.offsets - self.margin))
        begin = [self.height, float(self.leans), self.period, self.scale, self.least]
        return np.concatenate((begin, np.zeros(3), edges.ravel()))

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] the centre of mass is beyond each edge: there a floor cannot hold it.

        Where it is beyond none, standing still is always allowed.
        """
        inside = self.polygon.offsets - self.margin - self.polygon.normals @ kin.p_world_com[:2]
        return np.maximum(0.0, np.append(-inside, 0.0))

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return tuple(
            RowDescription.both(
                "the weight that has to stay on the soles"
                if label == "push"
                else f"the floor's push inside {label} of the soles",
                "m/s",
                math.nan,
            )
            for label in block.labels
        )
