"""A control period between MuJoCo's steps: forces out before each, sensors and state in after it.

Kernels read and write MuJoCo's own memory, at places looked up once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.workspace import Arrays, Block, Workspace, integers, part_of, vector
from equipoise.kinematics.kernels import is_finite
from equipoise.physics.mujoco.conversion import StateConversion, read_state, write_motion

ARRAYS = Arrays(
    ("q", "v", "force", "readings", "viscosity", "qpos_joints", "dof_joints", "sliding_dofs"),
    frozenset({"qpos_joints", "dof_joints", "sliding_dofs"}),
)
Q, V, FORCE, READINGS, VISCOSITY, QPOS_JOINTS, DOF_JOINTS, SLIDING_DOFS = range(len(ARRAYS.names))


class Period:
    """The memory of a control period.

    `q` (nq,), `v` (nv,) are the state after MuJoCo's last step; `force` (nv,) is the generalised
    force on the robot, held in base axes; `readings` the sum of the sensors over the steps.
    `sliding` gives by loose object its first degree of freedom and its viscosity [N s/m].
    """

    def __init__(
        self, conversion: StateConversion, simulated: Any, sliding: Sequence[tuple[int, float]]
    ) -> None:
        na, slides = len(conversion.dof_joints), len(sliding)
        shapes = ARRAYS.shapes(
            q=conversion.nq_base + na,
            v=conversion.nv_base + na,
            force=conversion.nv_base + na,
            readings=len(simulated.sensordata),
            viscosity=slides,
            qpos_joints=na,
            dof_joints=na,
            sliding_dofs=slides,
        )
        memory = Workspace({"period": shapes})
        part = memory.period
        part.qpos_joints[:], part.dof_joints[:] = conversion.qpos_joints, conversion.dof_joints
        for k, (dof, viscosity) in enumerate(sliding):
            part.sliding_dofs[k], part.viscosity[k] = dof, viscosity
        self.q, self.v, self.force, self.readings = part.q, part.v, part.force, part.readings
        ours = (memory.floats, memory.integers, memory.tables)
        theirs = (simulated.qpos, simulated.qvel, simulated.qfrc_applied)
        self._moved = (*ours, *theirs)
        self._read = (simulated.sensordata, simulated.warning.number)
        read_period(*self._moved)

    def begin(self) -> None:
        """Forget the readings and apply `force` to the present state."""
        self.readings[:] = 0.0
        apply_force(*self._moved)

    def take_step(self) -> bool:
        """Take in the step just done and apply `force` anew; tell whether nothing is wrong."""
        return take_step(*self._moved, *self._read)

    def read(self) -> None:
        """Take in the state only."""
        read_period(*self._moved)


@entrance
def read_period(
    floats: np.ndarray,
    whole: np.ndarray,
    tables: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
    qfrc: np.ndarray,
) -> None:
    """Write q and v from MuJoCo's."""
    period = part_of(floats, whole, tables, 0)
    places, dofs = integers(period, QPOS_JOINTS), integers(period, DOF_JOINTS)
    read_state(qpos, qvel, places, dofs, vector(period, Q), vector(period, V))


@entrance
def apply_force(
    floats: np.ndarray,
    whole: np.ndarray,
    tables: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
    qfrc: np.ndarray,
) -> None:
    """Write the force at the present state, and what resists the sliding of loose objects."""
    read_period(floats, whole, tables, qpos, qvel, qfrc)
    write_forces(part_of(floats, whole, tables, 0), qvel, qfrc)


@entrance
def take_step(
    floats: np.ndarray,
    whole: np.ndarray,
    tables: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
    qfrc: np.ndarray,
    sensors: np.ndarray,
    warnings: np.ndarray,
) -> bool:
    """Add the sensors of a step, and apply the force to the state it reached.

    Tell whether that state is finite and MuJoCo warned of nothing.
    """
    apply_force(floats, whole, tables, qpos, qvel, qfrc)
    readings = vector(part_of(floats, whole, tables, 0), READINGS)
    for i in range(readings.shape[0]):
        readings[i] += sensors[i]
    warned = 0
    for i in range(warnings.shape[0]):
        warned += warnings[i]
    return warned == 0 and is_finite(qpos) and is_finite(qvel)


@compiled
def write_forces(period: Block, qvel: np.ndarray, qfrc: np.ndarray) -> None:
    """Write the generalised forces in MuJoCo's order."""
    write_motion(vector(period, Q), vector(period, FORCE), integers(period, DOF_JOINTS), qfrc)
    viscosity, dofs = vector(period, VISCOSITY), integers(period, SLIDING_DOFS)
    for k in range(dofs.shape[0]):
        for i in range(dofs[k], dofs[k] + 2):
            qfrc[i] = -viscosity[k] * qvel[i]
