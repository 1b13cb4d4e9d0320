"""The inverse-dynamics program with one more row: the error's energy must not grow."""

from __future__ import annotations

import numpy as np

from equipoise.control.rivals.idqp import InverseDynamicsQP
from equipoise.control.rivals.rival import Tick
from equipoise.spatial import Array

STILL = 1e-9  # [sqrt(kg) m/s] of the error's motion below which its energy cannot change


class PassiveQP(InverseDynamicsQP):
    """`idqp` with passivity as a bound.

    With `V = |dv|_M^2 / 2 + alpha |dq|_D^2 / 2`, D = kappa M(q_0), and e the part of dv that the
    contacts allow (M-orthogonal), the program also holds

        e^T (M (a - a_ref) + C dv + alpha D dq) <= 0

    which is `dV/dt <= 0` on contacts that hold (dv = e). It is linear in a, and never in conflict
    with the contacts' equalities; it yields together with the floor's bounds where motors do not
    suffice. Source: Kurtz, Wensing, Lemmon and Lin 2021 (RA-L 6(2)), a whole-body program with a
    row that bounds the rate of a storage, so that the robot is passive; the storage is that of
    PD+ (Paden and Panja 1988). Differs: it is the storage of the whole configuration's error.
    """

    def more_bounds(self, tick: Tick, M: Array, h: Array) -> tuple[Array, Array, Array]:
        """Return the row of the energy, over the error's speed |e|_M."""
        J, dv = tick.rows.J, tick.dv
        e = dv.copy()
        if len(J):
            back = np.linalg.solve(M, J.T)
            e -= back @ np.linalg.lstsq(J @ back, J @ dv, rcond=1e-9)[0]
        speed = float(np.sqrt(e @ M @ e))
        D = self.damping(tick)
        if speed < STILL:
            return super().more_bounds(tick, M, h)
        e = e / speed
        C = self.dynamics.coriolis(tick.measured.q, tick.measured.v)
        row = np.concatenate((M @ e, np.zeros(self.contacts.size)))[None]
        most = e @ (M @ tick.a_ref - C @ dv - self.gains.alpha * (D @ tick.dq))
        return row, np.array([-np.inf]), np.array([most])
