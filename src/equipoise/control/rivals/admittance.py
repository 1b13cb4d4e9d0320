"""Admittance: a position servo whose reference gives way to the error of the contact force."""

from __future__ import annotations

import numpy as np

from equipoise.control.rivals.rival import Rival, Tick, Wanted
from equipoise.spatial import Array


class Admittance(Rival):
    """Forces are not commanded: the reference posture moves until they are as wanted.

        dx/dt = K^-1 J_f^T k_f (lam_f - f_ref)                 (x: shift of the reference, nv)
        u     = g(q) - K (dq - x) - D (dv - dx/dt) - K k_i z   D = kappa M(q_0), K = alpha D
        tau   = (u - J_S^T F)_joints,  F within the floor's bounds as for `gravity_contacts`

    The admittance `J_f K^-1 J_f^T k_f` makes a force error on a stiff contact die with the rate
    `k_f`. Source: Whitney 1977 (ASME JDSMC 99), accommodation: commanded velocity proportional to
    the force error; Caron, Kheddar and Tempier 2019 (ICRA), the same law in a humanoid's hands and
    feet. Differs: their position servos are the motors' own; here the servo is a PD on all
    coordinates with gravity through the contacts, and the feet are not given way.
    """

    def own_memory(self) -> dict[str, Array]:
        """Return the shift of the reference."""
        return {"shift": np.zeros(self.robot.nv)}

    def wanted(self, tick: Tick) -> Wanted:
        """Return the torque; the reference moves on by a period."""
        D, alpha, memory = self.damping(tick), self.gains.alpha, self.memory
        J_f = tick.rows.J[self.contacts.regulated_rows]
        speed = np.linalg.solve(alpha * D, J_f.T @ (self.gains.k_f * self.force_error(tick)))
        memory["shift"] = memory["shift"] + self.dt * speed
        s = tick.s - speed - alpha * memory["shift"]
        return self.carried(tick, self.dynamics.gravity(tick.measured.q) - D @ s, bounded=True)

    def force_error(self, tick: Tick) -> Array:
        """Return by how much the regulated contacts press too hard (k,)."""
        regulated = self.contacts.regulated_rows
        return tick.measured.lam[regulated] - tick.lam_ref
