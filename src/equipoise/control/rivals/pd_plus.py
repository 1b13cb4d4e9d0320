"""PD+: passivity-based tracking in full coordinates, inertia and Coriolis of the reference."""

from __future__ import annotations

from equipoise.control.rivals.rival import Rival, Tick, Wanted


class PDPlus(Rival):
    """The error's dynamics stay those of the robot, with a spring and a damper.

        u   = M(q) a_ref + C(q, v) v_ref + g(q) - D (dv + alpha dq + k_i z) - J_o^T f_w
        tau = (u - J_S^T F)_joints,  F as for `gravity_contacts`;  D = kappa M(q_0), constant

    Closed loop: `M d dv/dt + C dv + D dv + alpha D dq = 0`, so that with `k_i` = 0 the energy
    `|dv|_M^2 / 2 + alpha |dq|_D^2 / 2` falls by `|dv|_D^2`: no inertia is shaped.
    Source: Paden and Panja 1988 (Int. J. Control 47(6)), the PD+ law; Englsberger, Dietrich,
    Mesesan, Garofalo, Ott and Albu-Schaeffer 2020 (RSS, MPTC), whose one task here is the whole
    configuration. Differs: base rows go to bounded contact forces, as MPTC does in a program.
    """

    def wanted(self, tick: Tick) -> Wanted:
        """Return the torque."""
        q, v = tick.measured.q, tick.measured.v
        model = self.dynamics
        follow = model.inertia(q) @ tick.a_ref + model.coriolis(q, v) @ (v - tick.dv)
        u = follow + model.gravity(q) - self.damping(tick) @ tick.s
        return self.carried(tick, u - self.pressed(tick), bounded=True)
