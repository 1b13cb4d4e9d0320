"""The dynamics behind the law, for analysis only: regressor (18), error dynamics (19), (25).

The controller never sees any of it. Velocities are tangent velocities (base twist in base axes),
so the Coriolis matrix is that of the metric connection in this moving frame; see `reference_force`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.control import ControlGains
from equipoise.errors import ShapeError
from equipoise.robots import Robot
from equipoise.spatial import Array


@dataclass(frozen=True)
class Dynamics:
    """`M` (nv, nv), `C` (nv, nv), `g` (nv,) of (1) at one state; `D` (nv, nv) joint damping."""

    M: Array
    C: Array
    g: Array
    D: Array

    @classmethod
    def at(cls, robot: Robot, q: Array, v: Array, joint_damping: float = 0.0) -> Dynamics:
        """Return the dynamics of `robot` at `q` (nq,), `v` (nv,).

        `joint_damping` [N m s/rad] acts on every actuated joint.
        Source: eq. (1). Differs from the print: none.
        """
        model, data = robot.model, robot.model.createData()
        C = pin.computeCoriolisMatrix(model, data, q, v).copy()
        g = pin.computeGeneralizedGravity(model, data, q).copy()
        D = np.diag(np.concatenate((np.zeros(robot.nv_base), np.full(robot.na, joint_damping))))
        return cls(inertia(robot, q), C, g, D)

    def bias(self, v: Array) -> Array:
        """Return `h = C v + D v + g` (nv,)."""
        return (self.C + self.D) @ v + self.g

    def reference_force(self, v_r: Array, a_r: Array) -> Array:
        """Return `Y_r Theta = M a_r + (C + D) v_r + g` (nv,), C at the actual velocity."""
        return self.M @ a_r + (self.C + self.D) @ v_r + self.g


def inertia(robot: Robot, q: Array) -> Array:
    """Return the inertia matrix M (nv, nv) at `q` (nq,), the paper's H."""
    M = pin.crba(robot.model, robot.model.createData(), q)
    return np.triu(M) + np.triu(M, 1).T


def dynamic_parameters(robot: Robot) -> Array:
    """Return `Theta` (10 bodies,): mass, mass times centre, inertia at the joint, body by body."""
    return np.concatenate([body.toDynamicParameters() for body in robot.model.inertias[1:]])


def regressor(robot: Robot, q: Array, v: Array, a: Array) -> Array:
    """Return `Y(q, v, a)` (nv, 10 bodies) with `Y Theta = M a + C v + g`.

    Source: eq. (18). Differs from the print: without the damping term, which is not a parameter
    of a body.
    """
    for name, array in (("v", v), ("a", a)):
        if array.shape != (robot.nv,):
            raise ShapeError(name, array.shape, (robot.nv,))
    return pin.computeJointTorqueRegressor(robot.model, robot.model.createData(), q, v, a).copy()


def reference_regressor(robot: Robot, q: Array, v: Array, v_r: Array, a_r: Array) -> Array:
    """Return `Y_r` (nv, 10 bodies) with `Y_r Theta = M a_r + C(q, v) v_r + g`.

    The quadratic term is polarised, `(c(v + v_r) - c(v) - c(v_r)) / 2`, which in generalised
    coordinates is all. With a base twist it is not: `M - 2 C` is skew only with the torsion of
    the frame, `M [v, v_r] / 2`, whose bracket is the cross product of the two base twists.
    Source: after eq. (18). Differs from the print: the bracket, as the base velocity is no rate
    of coordinates.
    """
    still = np.zeros(robot.nv)
    bracket = still.copy()
    base = slice(robot.nv_base)
    bracket[base] = pin.Motion(v[base]).cross(pin.Motion(v_r[base])).vector
    at_rest = regressor(robot, q, still, still)
    quadratic = (
        regressor(robot, q, v + v_r, still)
        - regressor(robot, q, v, still)
        - regressor(robot, q, v_r, still)
        + at_rest
    )
    return regressor(robot, q, still, a_r + 0.5 * bracket) + 0.5 * quadratic


def error_force(dynamics: Dynamics, s: Array, s_rate: Array) -> Array:
    """Return `M ds/dt + (C + D) s` (nv,), the left-hand side of (19).

    Source: eq. (19). Differs from the print: none.
    """
    return dynamics.M @ s_rate + (dynamics.C + dynamics.D) @ s


def force_error_drive(
    s_rF: Array, s_rF_rate: Array, s_qF: Array, sign: Array, *, eta: float, k_iF: float, mu: float
) -> Array:
    """Return `Z_F` (k,) of the regulated rows; `sign` (k,) is what the law takes for sgn(s_qF).

    Source: eq. (26). Differs from the print: `k_iF sgn`, the gain is missing there.
    """
    return eta * s_rF + s_rF_rate - k_iF * sign + k_iF * np.tanh(mu * s_qF)


def lyapunov(M: Array, s: Array, s_rF: Array, beta: float) -> float:
    """Return V. Source: eq. (27). Differs from the print: none."""
    return 0.5 * float(s @ M @ s + beta * s_rF @ s_rF)


@dataclass(frozen=True)
class PowerBalance:
    """The terms of dV/dt [W]: what is dissipated, what the disturbance and the signs feed in.

    Source: eq. (28). Differs from the print: written out with `s^T J_phi^T = -beta s_rF^T`, and
    sgn stands for the sign function in use.
    """

    motion_dissipation: float
    force_dissipation: float
    disturbance: float
    sign_mismatch: float

    @property
    def rate(self) -> float:
        """dV/dt [W]."""
        return (
            self.disturbance + self.sign_mismatch - self.motion_dissipation - self.force_dissipation
        )

    @property
    def throughput(self) -> float:
        """Sum of the absolute terms [W], to compare residuals with."""
        return (
            abs(self.disturbance)
            + abs(self.sign_mismatch)
            + self.motion_dissipation
            + self.force_dissipation
        )


def power_balance(
    dynamics: Dynamics,
    gains: ControlGains,
    s: Array,
    reference_force: Array,
    *,
    s_rF: Array,
    s_qF: Array,
    sign: Array,
) -> PowerBalance:
    """Return the terms of (28) at one state; `reference_force` is `Y_r Theta` (nv,).

    `sign` (k,) is what the law takes for sgn(s_qF).
    """
    mismatch, K_d = np.tanh(gains.mu * s_qF) - sign, gains.damping_matrix(len(s))
    return PowerBalance(
        motion_dissipation=float(s @ (dynamics.D + K_d) @ s),
        force_dissipation=gains.beta * gains.eta * float(s_rF @ s_rF),
        disturbance=-float(s @ reference_force),
        sign_mismatch=-gains.beta * gains.k_iF * float(s_rF @ mismatch),
    )
