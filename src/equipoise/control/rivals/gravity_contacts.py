"""Gravity compensation and PD through the contacts: no inertia, no inverse dynamics."""

from __future__ import annotations

from equipoise.control.rivals.rival import Rival, Tick, Wanted


class GravityContacts(Rival):
    """The weight and a PD are given by ground forces, shared out optimally, turned to torques.

        u   = g(q) - D (dv + alpha dq + k_i z) - J_o^T f_w          D = kappa M(q_0), constant
        F   = argmin |F|_W  with  J_S,b^T F = u_b,  F within the floor's bounds
        tau = (u - J_S^T F)_joints

    Source: Hyon, Hale and Cheng 2007 (T-RO 23(5)): wanted ground force from gravity and feedback,
    its optimal distribution, joint torques by transposed Jacobians, damping of the joints; Hyon
    2009 (T-RO 25(1)) for friction and pressure as bounds. Differs: their feedback is on the centre
    of mass; here it is on the whole posture, as for all rivals. The wanted force is fed forward.
    """

    def wanted(self, tick: Tick) -> Wanted:
        """Return the torque."""
        u = self.dynamics.gravity(tick.measured.q) - self.damping(tick) @ tick.s
        return self.carried(tick, u - self.pressed(tick), bounded=True)
