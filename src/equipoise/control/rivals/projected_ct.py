"""Computed torque with projected dynamics: the contact forces drop out, the torque is least."""

from __future__ import annotations

import numpy as np

from equipoise.control.rivals.idqp import InverseDynamicsQP
from equipoise.control.rivals.rival import Tick, Wanted
from equipoise.spatial import Array

RANK = 1e-9  # singular values below this share of the largest one count as zero


class ProjectedComputedTorque(InverseDynamicsQP):
    """Computed torque in the directions that the supports leave free.

        a   = a_w + M^-1 J^T (J M^-1 J^T)^+ (b - J a_w)     (a_w, b as for `idqp`)
        tau = (P S^T)^+ P (M a + h - J_o^T f_w)             P = I - J_S^+ J_S

    The first line corrects the wanted acceleration by the dynamically consistent inverse, so that
    the contacts hold; in the second `P J_S^T = 0`, so that no supporting force has to be known.
    No cones and no centres of pressure: the authors had none. Torques are clamped.
    Source: Aghili 2005 (T-RO 21(5)), projection of the dynamics; Mistry and Righetti 2011 (RSS),
    underactuation by `(P S^T)^+`; Khatib 1987 and Sentis and Khatib 2005, the consistent inverse.
    """

    def wanted(self, tick: Tick) -> Wanted:
        """Return the least torque."""
        base, nv = self.robot.nv_base, self.robot.nv
        q, v = tick.measured.q, tick.measured.v
        M = self.dynamics.inertia(q)
        u = M @ self.consistent(tick, M) + self.dynamics.bias(q, v) - self.pressed(tick)
        J_S = tick.rows.J[self.contacts.supporting_rows]
        Q = _range_of(J_S.T)
        P = np.eye(nv) - Q @ Q.T
        tau = np.asarray(np.linalg.lstsq(P[:, base:], P @ u, rcond=RANK)[0], dtype=float)
        rest = u - np.concatenate((np.zeros(base), tau))
        F = np.linalg.lstsq(J_S.T, rest, rcond=RANK)[0] if len(J_S) else np.zeros(0)
        return Wanted(tau, u, F)

    def consistent(self, tick: Tick, M: Array) -> Array:
        """Return the wanted acceleration (nv,), corrected so that the contacts hold."""
        J, a = tick.rows.J, self.acceleration(tick)
        if not len(J):
            return a
        back = np.linalg.solve(M, J.T)
        missing = self.contact_accelerations(tick) - J @ a
        return a + back @ np.linalg.lstsq(J @ back, missing, rcond=RANK)[0]


def _range_of(A: Array) -> Array:
    """Return orthonormal columns that span the columns of A (n, k)."""
    if not A.shape[1]:
        return A
    U, size, _ = np.linalg.svd(A, full_matrices=False)
    return U[:, size > RANK * size[0]]
