"""Inverse dynamics by a quadratic program, in TSID's form: accelerations and contact forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.control.rivals.quadratic import minimise
from equipoise.control.rivals.rival import Rival, Tick, Wanted
from equipoise.spatial import Array

FORCE_WEIGHT = 1e-1  # [1/kg] of a wanted contact force: a task of its own
SUPPORT_WEIGHT = 1e-5  # [1/kg] of a supporting force times its cost: regularisation
OTHER_WEIGHT = 1e-3  # [1/kg] of every other multiplier: regularisation


class Optimum(NamedTuple):
    """Accelerations `a`, forces `f`, torques `tau` of a program, with the dynamics behind them.

    `solved`: no bound had to be violated; `bounded`: a bound had a say.
    """

    a: Array
    f: Array
    tau: Array
    M: Array
    h: Array
    solved: bool
    bounded: bool


class InverseDynamicsQP(Rival):
    """Accelerations and forces near what is wanted, within what motors and floor can give.

    Unknowns `a` (nv,) and `f` (r,), torques eliminated:

        min  |a - a_w|_M^2 + sum_i w_i (f_i - f_w,i)^2
        with M_b a + h_b = J_b^T f                              (the base has no motor)
             J a = -drift - 2 c (J v - rate) - c^2 residual     (contacts hold; c: contact_rate)
             |M_j a + h_j - J_j^T f| <= tau_max
             floor: pyramids, centres of pressure, yaw moments; f >= 0 of what only pushes
        a_w = a_ref - kappa (dv + alpha dq + k_i z)

    `tau = M_j a + h_j - J_j^T f`. `f_w` is the wanted force of a regulated row, zero else.
    Source: Del Prete, Mansard, Ramos, Stasse and Nori 2016 (the program with torques eliminated,
    section "TSID"), and the library TSID, `InverseDynamicsFormulationAccForce`. Differs: a sole
    has its wrench as unknown and the wrench cone as bounds, where TSID has forces at four corners
    (the same set for equal pyramids); one task for the whole configuration, weighted by M (least
    constraint), where TSID adds tasks with a scalar each: `plain` weighs it so, by 1; the integral
    of force error and `k_i` are ours.
    """

    plain = False
    support_weight = SUPPORT_WEIGHT

    def wanted(self, tick: Tick) -> Wanted:
        """Return the torque of the optimum."""
        found = self.optimum(tick)
        others = self.others
        u = found.M @ found.a + found.h - tick.rows.J[others].T @ found.f[others]
        return Wanted(found.tau, u, found.f[self.contacts.supporting_rows])

    def optimum(self, tick: Tick) -> Optimum:
        """Solve the program of a tick."""
        nv, J, base = self.robot.nv, tick.rows.J, self.robot.nv_base
        r = len(J)
        M = self.dynamics.inertia(tick.measured.q)
        h = self.dynamics.bias(tick.measured.q, tick.measured.v)
        give = np.hstack((M, -J.T))  # times (a, f), plus h: what the motors give
        equal = (
            np.vstack((give[:base], np.hstack((J, np.zeros((r, r)))))),
            np.concatenate((-h[:base], self.contact_accelerations(tick))),
        )
        bounds = self._bounds(give[base:], h[base:], self.more_bounds(tick, M, h))
        soft = np.arange(len(bounds[1])) >= self.robot.na  # motors cannot give more
        goal = np.concatenate((self.acceleration(tick), tick.forces))
        answer = minimise(self._metric(M), goal, equal, bounds, soft)
        a, f = answer.x[:nv], answer.x[nv:]
        tau = (M @ a + h - J.T @ f)[base:]
        return Optimum(a, f, tau, M, h, answer.solved, answer.bounded)

    def _metric(self, M: Array) -> Array:
        """Return the factor of the weights of (a, f)."""
        nv, contacts = self.robot.nv, self.contacts
        weights = np.full(contacts.size, OTHER_WEIGHT)
        weights[contacts.regulated_rows] = FORCE_WEIGHT
        weights[contacts.supporting_rows] = self.support_weight * self.floor.costs**2
        metric = np.diag(np.concatenate((np.ones(nv), np.sqrt(weights))))
        if not self.plain:
            metric[:nv, :nv] = np.linalg.cholesky(M).T
        return metric

    def acceleration(self, tick: Tick) -> Array:
        """Return the wanted acceleration (nv,)."""
        return tick.a_ref - self.gains.kappa * tick.s

    def contact_accelerations(self, tick: Tick) -> Array:
        """Return `J a` (r,) that keeps or closes the contacts; `drift` holds the rate's own."""
        rows, c = tick.rows, self.gains.contact_rate
        violation = rows.J @ tick.measured.v - rows.rate
        return -rows.drift - 2.0 * c * violation - c * c * rows.residual

    def more_bounds(self, tick: Tick, M: Array, h: Array) -> tuple[Array, Array, Array]:
        """Return further bounds (A, lower, upper) on (a, f): none here."""
        n = self.robot.nv + self.contacts.size
        return np.zeros((0, n)), np.zeros(0), np.zeros(0)

    def _bounds(
        self, torque: Array, h: Array, more: tuple[Array, Array, Array]
    ) -> tuple[Array, Array, Array]:
        """Return torque limits, the floor's bounds, what only pushes, and more."""
        nv, floor = self.robot.nv, self.floor
        limit = self.robot.tau_max
        n = torque.shape[1]
        cones = np.zeros((len(floor.b), n))
        cones[:, nv + self.contacts.supporting_rows] = floor.A
        push = np.zeros((len(self.pressing), n))
        push[np.arange(len(self.pressing)), nv + self.pressing] = 1.0
        above = np.concatenate((floor.b, np.zeros(len(push))))
        return (
            np.vstack((torque, cones, push, more[0])),
            np.concatenate((-limit - h, above, more[1])),
            np.concatenate((limit - h, np.full(len(above), np.inf), more[2])),
        )
