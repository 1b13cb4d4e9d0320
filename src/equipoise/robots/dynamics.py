"""The joint-space dynamics of a model, `M dv/dt + C v + g`, for whoever may know a model.

Pinocchio's composite rigid body algorithm and its Coriolis matrix are wrong where a joint follows
another one that is not its neighbour (4.1.0; its Newton-Euler recursion is right). There both
are those of the uncoupled model, folded by G: see `equipoise.kinematics.followers`.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.kinematics.followers import Uncoupled, followers_of, uncoupled
from equipoise.spatial import Array


class JointDynamics:
    """Inertia, bias, gravity and Coriolis matrix of a model, rotors (`armature`) included."""

    def __init__(self, model: pin.Model) -> None:
        self._model, self._data = model, model.createData()
        self._whole: Uncoupled | None = None
        if followers_of(model):
            self._whole = uncoupled(model)
            self._whole_data = self._whole.model.createData()

    def inertia(self, q: Array) -> Array:
        """Return `M` (nv, nv) at `q` (nq,)."""
        if self._whole is None:
            return np.array(pin.crba(self._model, self._data, q), order="C")
        G = self._whole.G
        M = pin.crba(self._whole.model, self._whole_data, self._whole.spread(q))
        return np.array(G.T @ M @ G + np.diag(self._model.armature), order="C")

    def bias(self, q: Array, v: Array) -> Array:
        """Return `h = C v + g` (nv,)."""
        return np.array(pin.nonLinearEffects(self._model, self._data, q, v))

    def gravity(self, q: Array) -> Array:
        """Return `g` (nv,)."""
        return np.array(pin.computeGeneralizedGravity(self._model, self._data, q))

    def coriolis(self, q: Array, v: Array) -> Array:
        """Return `C` (nv, nv), with `dM/dt - 2 C` skew-symmetric."""
        if self._whole is None:
            return np.array(pin.computeCoriolisMatrix(self._model, self._data, q, v))
        whole, memory = self._whole, self._whole_data
        C = pin.computeCoriolisMatrix(whole.model, memory, whole.spread(q), whole.G @ v)
        return np.asarray(whole.G.T @ C @ whole.G)
