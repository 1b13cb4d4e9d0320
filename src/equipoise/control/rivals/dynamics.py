"""The nominal dynamics that a rival knows: `M a + h = S^T tau + J^T lam`, by Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.robots import Robot
from equipoise.spatial import Array


class NominalDynamics:
    """Inertia, bias, gravity and Coriolis matrix of a robot, rotors (`armature`) included."""

    def __init__(self, robot: Robot) -> None:
        self._model, self._data = robot.model, robot.model.createData()

    def inertia(self, q: Array) -> Array:
        """Return `M` (nv, nv)."""
        M = pin.crba(self._model, self._data, q)
        return np.triu(M) + np.triu(M, 1).T

    def bias(self, q: Array, v: Array) -> Array:
        """Return `h = C v + g` (nv,)."""
        return np.array(pin.nonLinearEffects(self._model, self._data, q, v))

    def gravity(self, q: Array) -> Array:
        """Return `g` (nv,)."""
        return np.array(pin.computeGeneralizedGravity(self._model, self._data, q))

    def coriolis(self, q: Array, v: Array) -> Array:
        """Return `C` (nv, nv), with `dM/dt - 2 C` skew-symmetric."""
        return np.array(pin.computeCoriolisMatrix(self._model, self._data, q, v))
