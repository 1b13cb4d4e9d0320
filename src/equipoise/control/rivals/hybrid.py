"""Hybrid position/force control: directions of force are taken out of the position servo."""

from __future__ import annotations

import numpy as np

from equipoise.control.rivals.rival import Rival, Tick, Wanted


class HybridPositionForce(Rival):
    """A selection of directions is controlled in force, all others in position.

        N   = I - J_f^# J_f,  J_f^# = D^-1 J_f^T (J_f D^-1 J_f^T)^-1     (J_f: regulated rows)
        u   = g(q) - D N (dv + alpha dq + k_i z) - J_f^T (f_ref - k_f integral of df)
        tau = (u - J_S^T F)_joints,  F of least cost with J_S,b^T F = u_b;  D = kappa M(q_0)

    Source: Raibert and Craig 1981 (ASME JDSMC 103): position errors times the selection I - S,
    force errors times S, each with a servo of its own; Fisher and Mujtaba 1992 (IJRR 11(4)): the
    selection goes into the Jacobian, not beside its inverse, which is unstable. Differs: the
    inverse is weighted by D, gravity of the nominal model is added, and a floating base, which
    they had not, is carried by least supporting forces without bounds.
    """

    def wanted(self, tick: Tick) -> Wanted:
        """Return the torque."""
        D, s = self.damping(tick), tick.s
        J_f = tick.rows.J[self.contacts.regulated_rows]
        if len(J_f):
            back = np.linalg.solve(D, J_f.T)
            s = s - back @ np.linalg.lstsq(J_f @ back, J_f @ s, rcond=1e-9)[0]
        u = self.dynamics.gravity(tick.measured.q) - D @ s
        return self.carried(tick, u - self.pressed(tick), bounded=False)
