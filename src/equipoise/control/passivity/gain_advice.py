"""Offline advice on gains: uses the nominal model once, so that the law never has to see it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.contacts.stack import StackedContacts
from equipoise.control.passivity.gains import Projector
from equipoise.control.passivity.nearest import NearestVelocity
from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, positive, real_vector, require_period
from equipoise.spatial.numbers import share as fraction

_POSTURES = 200
LONGEST_DELAY = 0.1  # [s]
_ROUNDING = 1e-9
# of the dead time that the posture loop survives on a floor that gives
RESERVES: dict[Projector, float] = {"euclidean": 6.0, "damping": 3.0}


@dataclass(frozen=True)
class GainAdvice:
    """A constant `K_d = kappa M(q_0)` and how far it is from the edge.

    `kappa_max_rigid` [1/s]: sampled damping `v <- v - dt M^-1 K_d v` on the tangent space of rigid
    contacts is stable below it (2/dt for K_d proportional to M). `kappa_max_free` [1/s], by
    projector: the same with the supporting contacts gone, for the torque that really reaches the
    joints after the base wrench was handed over; a soft contact lies between the two.
    `delay_margin` [s]: delay that the loop of damping and stiffness survives on rigid contacts.
    """

    K_d: Array
    kappa: float
    kappa_max_rigid: float
    kappa_max_free: Mapping[str, float]
    delay_margin: float
    ratio_diagonal: float
    shape: str = "M(q_0)"

    def sentences(self) -> tuple[str, ...]:
        """Return the advice in words, one sentence a line."""
        share, free = 100.0 * self.kappa / self.kappa_max_rigid, self.kappa_max_free
        return (
            f"K_d = {self.kappa:g} {self.shape}: {share:.0f} % of the bound "
            f"{self.kappa_max_rigid:.0f} 1/s on rigid contacts.",
            f"With the supporting contacts gone it is {free['euclidean']:.1f} 1/s with the "
            f"projector as printed, {free['damping']:.0f} 1/s with that of K_d.",
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
    Raises: `InputError` for a number that is not finite or has the wrong sign.
    """
    require_period(dt)
    positive("alpha", alpha, "1/s")
    fraction("share", share)
    rotors = rotors_of(robot, rotor_inertia)
    if kappa is not None:
        positive("kappa", kappa, "1/s")
    M = inertia_matrix(robot, q_0)
    motors = range(robot.nv_base, robot.nv)
    M[motors, motors] += rotors
    stacked = contacts.at(robot.at(q_0))
    Z = null_space(stacked.J_phi) if contacts.size else np.eye(robot.nv)
    M_tangent = Z.T @ M @ Z
    diagonal = np.diag(np.diag(M))
    ratio = _largest(Z.T @ diagonal @ Z, M_tangent)
    bound = 2.0 / (dt * _largest(M_tangent, M_tangent))
    chosen = share * bound if kappa is None else kappa
    return GainAdvice(
        K_d=chosen * M,
        kappa=chosen,
        kappa_max_rigid=bound,
        kappa_max_free=_free_bounds(robot, stacked, M, dt),
        delay_margin=delay_margin(chosen, alpha),
        ratio_diagonal=ratio,
    )


def advise_for_postures(
    robot: Robot,
    contacts: ContactStack,
    q_0: Array,
    dt: float,
    *,
    alpha: float,
    kappa: float | None = None,
    rotor_inertia: float | Array = 0.0,
) -> GainAdvice:
    """Suggest one constant `K_d` that a loop of period `dt` [s] survives wherever the arms are.

    With `K_d = kappa M(q_0)` sampled damping is stable while `lambda_max(M(q_0), M(q))` is below
    `2 / (kappa dt)`. On the way to a stretched arm that eigenvalue grows from 1 to 40 or 200: the
    loop then flips its torque every tick, however gentle the reference. Here `K_d = kappa H` with
    the harmonic mean H of M over postures (seeded, uniform within the joint limits; legs as at
    `q_0` (nq,)), which no posture undercuts by much. `kappa` [1/s] is taken as given, or chosen as
    half of the bound at the worst of them, which is `kappa_max_rigid`. What is paid: directions
    that are heavy in most postures are damped less than with M(q_0).
    Source: Franklin, Powell and Workman 1998 (sampled damping); the mean is our own.
    Raises: `InputError` for a number that is not finite or has the wrong sign.
    """
    require_period(dt)
    positive("alpha", alpha, "1/s")
    rotors = rotors_of(robot, rotor_inertia)
    if kappa is not None:
        positive("kappa", kappa, "1/s")
    stacked = contacts.at(robot.at(q_0))
    Z = null_space(stacked.J_phi) if contacts.size else np.eye(robot.nv)
    motors = range(robot.nv_base, robot.nv)
    inertias = [inertia_matrix(robot, q) for q in random_postures(robot, q_0, _POSTURES, seed=0)]
    for M in inertias:
        M[motors, motors] += rotors
    H = np.linalg.inv(np.mean([np.linalg.inv(M) for M in inertias], axis=0))
    H = 0.5 * (H + H.T)
    H_tangent = Z.T @ H @ Z
    worst = max(_largest(H_tangent, Z.T @ M @ Z) for M in inertias)
    bound = 2.0 / (dt * worst)
    chosen = 0.5 * bound if kappa is None else kappa
    return GainAdvice(
        K_d=chosen * H,
        kappa=chosen,
        kappa_max_rigid=bound,
        kappa_max_free=_free_bounds(robot, stacked, H, dt),
        delay_margin=delay_margin(chosen * worst, alpha),
        ratio_diagonal=_largest(Z.T @ np.diag(np.diag(H)) @ Z, H_tangent),
        shape="the mean of M over postures",
    )


def bear_postures(
    advice: GainAdvice,
    robot: Robot,
    contacts: ContactStack,
    postures: Sequence[Array],
    dt: float,
    *,
    share: float = 0.5,
    rotor_inertia: float | Array = 0.0,
) -> GainAdvice:
    """Return the advice with a `K_d` below it that a loop of period `dt` [s] bears in all postures.

    Sampled damping is stable in a posture (nq,) while `K_d < (2 / dt) M(q)` on the tangent space of
    the contacts. A direction u there that exceeds `share` of that is damped less: `K_d - c K_d u
    u^T K_d` with the c that leaves it at the bound. So `K_d` never grows, stays positive, and all
    other directions keep what they had: what a stretched arm cannot bear is damping about its own
    axis. Advice that is borne is returned as it is.
    Raises: `InputError`, `ShapeError`.
    """
    limit = fraction("share", share) * 2.0 / require_period(dt)
    rotors, K = rotors_of(robot, rotor_inertia), advice.K_d
    motors, cut = range(robot.nv_base, robot.nv), False
    for q in postures:
        M = inertia_matrix(robot, q)
        M[motors, motors] += rotors
        J = contacts.at(robot.at(q)).J_phi if contacts.size else np.zeros((0, robot.nv))
        Z = null_space(J) if len(J) else np.eye(robot.nv)
        values, X = eigenvectors(Z.T @ K @ Z, Z.T @ M @ Z)
        over = values > limit * (1.0 + _ROUNDING)
        if over.any():
            W, cut = K @ Z @ X[:, over], True
            K = K - (W * ((1.0 - limit / values[over]) / values[over])) @ W.T
    if not cut:
        return advice
    return replace(advice, K_d=K, shape=f"{advice.shape}, less where stretched postures bear less")


def random_postures(robot: Robot, q_0: Array, count: int, *, seed: int) -> list[Array]:
    """Return configurations (nq,) with the joints that carry no sole anywhere in their limits."""
    rng = np.random.default_rng(seed)
    legs = {i for sole in robot.soles for i in robot.joints_between(sole.frame)}
    free = [i for i in range(robot.na) if i not in legs]
    postures = []
    for _ in range(count):
        q = np.array(q_0, dtype=float)
        q[[robot.nq_base + i for i in free]] = rng.uniform(robot.q_min[free], robot.q_max[free])
        postures.append(q)
    return postures


def rotors_of(robot: Robot, inertia: float | Array) -> Array:
    """Return the rotor inertia (na,) [kg m^2] of every joint, given as one number or as (na,).

    Raises: `ShapeError`, `NonFiniteError`, `InputError` for a negative one.
    """
    if np.ndim(inertia) == 0:
        inertia = np.full(robot.na, not_negative("rotor_inertia", inertia, "kg m^2"))
    rotors = real_vector("rotor_inertia", inertia, robot.na)
    for name, one in zip(robot.joint_names, rotors, strict=True):
        not_negative(f"the rotor inertia of {name}", one, "kg m^2")
    return rotors


def inertia_matrix(robot: Robot, q: Array) -> Array:
    """Return the joint-space inertia matrix M (nv, nv) at `q` (nq,)."""
    return JointDynamics(robot.model).inertia(q)


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
    delay: float,
    dt: float,
    k_ip: float,
    *,
    projector: Projector = "euclidean",
    reserve: float | None = None,
) -> SoftFloorGains:
    """Choose the posture loop so slow that it survives `reserve` times the loop's dead time.

    With the projector that is orthogonal in K_d the floor takes no part in that loop, and a
    reserve of three is left out of it by default; with the Euclidean one it does: six.
    The dead time is `delay` [s] and one and a half periods `dt` [s] of sampling and holding.
    Damping is five times as fast as the posture (`alpha = kappa / 5`), and the integral inside
    the boundary layer at most half as fast as the damping (`k_ip / layer = kappa / 2`), so that
    the two do not swing against each other.
    Raises: `InputError` if a time or the reserve is not positive, or the delay is above 0.1 s.
    """
    require_period(dt)
    if positive("delay", delay, "s") > LONGEST_DELAY:
        raise InputError(
            f"no gains keep a robot on its feet that is felt later than {LONGEST_DELAY:g} s",
            given=delay,
            remedy="Give the delay in seconds: 3 ms are 0.003",
        )
    reserve = RESERVES[projector] if reserve is None else positive("reserve", reserve)
    not_negative("k_ip", k_ip, "rad/s^2")
    wanted = reserve * (delay + 1.5 * dt)
    # With alpha proportional to kappa the margin is inversely proportional to kappa.
    kappa = delay_margin(1.0, 0.2) / wanted
    return SoftFloorGains(kappa, kappa / 5.0, max(2.0 * k_ip / kappa, 1e-3))


def _free_bounds(robot: Robot, stacked: StackedContacts, M: Array, dt: float) -> dict[str, float]:
    """Return by projector the kappa [1/s] below which `K_d = kappa M` is stable, the feet free."""
    P = handed_over(stacked.J_phi[stacked.stack.supporting_rows], robot.nv_base)
    kept = {"euclidean": stacked.Q_phi, "damping": NearestVelocity(stacked.J_phi, M).N}
    gains = {name: np.linalg.eigvals(np.linalg.solve(M, P @ M @ Q)) for name, Q in kept.items()}
    return {name: 2.0 / (dt * float(np.abs(gain).max())) for name, gain in gains.items()}


def handed_over(J_r: Array, base: int) -> Array:
    """Return P (nv, nv), which leaves of u what remains when the feet carry its `base` rows.

    `J_r` (k, nv) are the rows of the supporting contacts.
    """
    P = np.eye(J_r.shape[1])
    if base:
        P[:, :base] -= J_r.T @ np.linalg.pinv(J_r[:, :base].T)
        P[:base] = 0.0
    return P


def _largest(K: Array, M: Array) -> float:
    return float(eigenvalues(K, M)[-1])


def eigenvalues(K: Array, M: Array) -> Array:
    """Return, ascending, the eigenvalues (n,) of `K x = lambda M x`; M is positive definite."""
    return eigenvectors(K, M)[0]


def eigenvectors(K: Array, M: Array) -> tuple[Array, Array]:
    """Return the same, and the vectors X (n, n) in columns, with `X^T M X` the identity."""
    L = np.linalg.cholesky(M)
    half = np.linalg.solve(L, K)
    values, Y = np.linalg.eigh(np.linalg.solve(L, half.T))
    return values, np.linalg.solve(L.T, Y)


def null_space(J: Array) -> Array:
    """Return an orthonormal basis (n, k) of what the rows of `J` (m, n) do not see."""
    _, s, right = np.linalg.svd(J, full_matrices=True)
    rank = int((s > s[0] * max(J.shape) * np.finfo(float).eps).sum()) if len(s) else 0
    return right[rank:].T
