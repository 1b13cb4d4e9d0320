"""An inelastic impact: contacts come to rest at once, by the least kinetic energy of the change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.contacts import Contact, ContactStack
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array


@dataclass(frozen=True)
class Impact:
    """Velocity `v` (nv,) behind an impact, impulses by contact, kinetic energy `lost` [J]."""

    v: Array
    impulses: Mapping[str, Array]
    lost: float


def inelastic_impact(
    robot: Robot, kin: Kinematics, v: Array, contacts: Sequence[Contact]
) -> Impact:
    """Return what an impact makes of a velocity (nv,): no row of the contacts moves behind it.

    `M (v+ - v) = J^T p`, `J v+ = nu_c`; the energy lost is `1/2 (J v)^T (J M^-1 J^T)^-1 (J v)`
    where the contacts stand. Redundant rows share the least impulse.
    Source: Featherstone 2008, chapter 11. Differs from the print: none.
    """
    stack = ContactStack(contacts)
    J = stack.jacobian(kin)
    M = JointDynamics(robot.model).inertia(kin.q.copy())
    half = np.linalg.solve(M, J.T)
    gap = J @ v - stack.rate(kin)
    p = np.asarray(np.linalg.lstsq(J @ half, -gap, rcond=1e-12)[0], dtype=np.float64)
    after = v + half @ p
    lost = 0.5 * float(v @ M @ v - after @ M @ after)
    return Impact(after, {name: p[rows] for name, rows in stack.rows.items()}, lost)
