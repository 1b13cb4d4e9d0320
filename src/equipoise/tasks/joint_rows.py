"""Rows that are the velocities of the joints, one each."""

from __future__ import annotations

from typing import Any

from equipoise.spatial import Array


def write_joint_rows(A: Array, robot: Any) -> None:
    """Write the unit rows `A` (na, nv) of the actuated joints, which follow the base."""
    for i in range(len(A)):
        A[i, robot.nv_base + i] = 1.0
