"""Offline advice on gains: uses the nominal model once, so that the law never has to see it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import scipy.linalg

from equipoise.contacts import ContactStack
from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.spatial import Array


@dataclass(frozen=True)
class GainAdvice:
    """A constant `K_d = kappa M(q_0)` and how far it is from the edge.

    `kappa_max_rigid` [1/s]: sampled damping `v <- v - dt M^-1 K_d v` on the tangent space of rigid
    contacts is stable below it (2/dt for K_d proportional to M). `kappa_max_free` [1/s]: the same
    with the supporting contacts gone, for the torque that really reaches the joints after the
    base wrench was handed over and Q_phi applied; a soft contact lies between the two.
    `delay_margin` [s]: delay that the loop of damping and stiffness survives on rigid contacts.
    """

    K_d: Array
    kappa: float
    kappa_max_rigid: float
    kappa_max_free: float
    delay_margin: float
    ratio_diagonal: float

    def sentences(self) -> tuple[str, ...]:
        """Return the advice in words, one sentence a line."""
        return (
            f"K_d = {self.kappa:g} M(q_0): {100 * self.kappa / self.kappa_max_rigid:.0f} % of the "
            f"bound {self.kappa_max_rigid:.0f} 1/s on rigid contacts.",
            f"With the supporting contacts gone the bound is {self.kappa_max_free:.1f} 1/s.",
            f"A delay of up to {1e3 * self.delay_margin:.1f} ms leaves the loop stable.",
            f"A diagonal K_d would have to be {self.ratio_diagonal:.0f} times smaller.",
        )


def advise_gains(
    robot: Robot,
    contacts: ContactStack,
    q_0: Array,
    dt: float,
    *,
    alpha: float,
    share: float = 0.15,
    kappa: float | None = None,
    rotor_inertia: float | Array = 0.0,
) -> GainAdvice:
    """Suggest `K_d = kappa M(q_0)` for a loop of period `dt` [s] and posture rate `alpha` [1/s].

    `kappa` [1/s] is taken as given, or chosen as `share` of the bound on rigid contacts.
    `rotor_inertia` [kg m^2] of every joint, one or (na,), as seen behind its gear, is added to M.
    Raises: `InputError` if the period is not positive.
    """
    if not dt > 0.0:
        raise InputError("the control period must be positive", given=dt)
    M = inertia_matrix(robot, q_0)
    motors = range(robot.nv_base, robot.nv)
    M[motors, motors] += rotor_inertia
    stacked = contacts.at(robot.at(q_0))
    Z = scipy.linalg.null_space(stacked.J_phi) if contacts.size else np.eye(robot.nv)
    M_tangent = Z.T @ M @ Z
    diagonal = np.diag(np.diag(M))
    ratio = _largest(Z.T @ diagonal @ Z, M_tangent)
    bound = 2.0 / (dt * _largest(M_tangent, M_tangent))
    chosen = share * bound if kappa is None else kappa
    return GainAdvice(
        K_d=chosen * M,
        kappa=chosen,
        kappa_max_rigid=bound,
        kappa_max_free=2.0 / (dt * _free_gain(robot, contacts, stacked.J_phi, stacked.Q_phi, M)),
        delay_margin=delay_margin(chosen, alpha),
        ratio_diagonal=ratio,
    )


def inertia_matrix(robot: Robot, q: Array) -> Array:
    """Return the joint-space inertia matrix M (nv, nv) at `q` (nq,)."""
    M = pin.crba(robot.model, robot.model.createData(), q)
    return np.triu(M) + np.triu(M, 1).T


def delay_margin(kappa: float, alpha: float) -> float:
    """Return the delay [s] at which `dv/dt = -kappa (v + alpha q)` loses its stability.

    With K_d proportional to the inertia each tangent direction is this loop. It crosses unit gain
    at omega with `kappa |j omega + alpha| = omega^2`; the margin is phase over omega there.
    """
    half = 0.5 * kappa * kappa
    omega = np.sqrt(half + np.sqrt(half * half + (kappa * alpha) ** 2))
    return float(np.arctan2(omega, alpha) / omega)


@dataclass(frozen=True)
class SoftFloorGains:
    """Gains for a floor that gives: `kappa`, `alpha` [1/s] and the `layer` [rad/s] of sgn_p."""

    kappa: float
    alpha: float
    layer: float


def advise_for_soft_floor(
    delay: float, dt: float, k_ip: float, *, reserve: float = 6.0
) -> SoftFloorGains:
    """Choose the posture loop so slow that it survives `reserve` times the loop's dead time.

    The dead time is `delay` [s] and one and a half periods `dt` [s] of sampling and holding.
    Damping is five times as fast as the posture (`alpha = kappa / 5`), and the integral inside
    the boundary layer at most half as fast as the damping (`k_ip / layer = kappa / 2`), so that
    the two do not swing against each other.
    Raises: `InputError` if a time or the reserve is not positive.
    """
    if not (delay > 0.0 and dt > 0.0 and reserve > 0.0):
        raise InputError("delay, period and reserve must be positive", given=(delay, dt, reserve))
    wanted = reserve * (delay + 1.5 * dt)
    # With alpha proportional to kappa the margin is inversely proportional to kappa.
    kappa = delay_margin(1.0, 0.2) / wanted
    return SoftFloorGains(kappa, kappa / 5.0, max(2.0 * k_ip / kappa, 1e-3))


def _free_gain(robot: Robot, contacts: ContactStack, J_phi: Array, Q_phi: Array, M: Array) -> float:
    """Return the largest |eigenvalue| of `M^-1 P K Q_phi`, K = M, with the feet free.

    P maps u to the generalised force that remains when its base rows were handed to the feet.
    """
    J_r = J_phi[contacts.supporting_rows]
    base = robot.nv_base
    P = np.eye(robot.nv)
    if base:
        P[:, :base] -= J_r.T @ np.linalg.pinv(J_r[:, :base].T)
        P[:base] = 0.0
    return float(np.abs(np.linalg.eigvals(np.linalg.solve(M, P @ M @ Q_phi))).max())


def _largest(K: Array, M: Array) -> float:
    return float(scipy.linalg.eigh(K, M, eigvals_only=True)[-1])
