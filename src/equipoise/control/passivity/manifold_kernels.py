"""Kernels of the two error manifolds (22), (23); each memory is one array, a row a quantity."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, entrance

SIGN, TANH, SATURATION = range(3)  # kinds of sign functions
# rows of the memory of the posture manifold, and of the force manifold
S_P0, INTEGRAL, S_P, S_QP, S_RP, GROWTH = range(6)
S_F0, INTEGRAL_F, S_F, S_QF, S_RF, RATE_OF_S_DF = range(6)


@entrance
def sign_of(x: np.ndarray, kind: int, layer: float, out: np.ndarray) -> None:
    """Write the sign of `x` by component."""
    for i in range(x.shape[0]):
        out[i] = soft_sign(x[i], kind, layer)


@compiled
def soft_sign(x: float, kind: int, layer: float) -> float:
    """Return sgn x, tanh(x / layer), or x / layer cut at -1 and 1."""
    if kind == SIGN:
        return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)
    if kind == TANH:
        return math.tanh(x / layer)
    return min(max(x / layer, -1.0), 1.0)


@compiled
def soft_root(x: float, layer: float) -> float:
    """Return sgn(x) |x|^(1/2), with the slope layer^(-1/2) at zero instead of an infinite one."""
    return x / math.sqrt(abs(x) + layer) if x != 0.0 else 0.0


@compiled
def posture_update(
    memory: np.ndarray, dq: np.ndarray, dv: np.ndarray, age: float, alpha: float, beta_p: float,
    k_ip: float, root: float, layer: float,
) -> None:  # fmt: skip
    """Write s_p, s_qp and s_rp at `age` = t - t0. Source: eq. (22a)-(22d), see the class."""
    forgotten = math.exp(-beta_p * age)
    for i in range(memory.shape[1]):
        memory[S_P, i] = dv[i] + alpha * dq[i]
        memory[S_QP, i] = memory[S_P, i] - memory[S_P0, i] * forgotten
        memory[S_RP, i] = memory[S_QP, i] + k_ip * memory[INTEGRAL, i]
        if root > 0.0:
            memory[S_RP, i] += root * soft_root(memory[S_QP, i], layer)


@compiled
def posture_integrate(
    memory: np.ndarray,
    s_qp_tangent: np.ndarray,
    held: np.ndarray,
    dt: float,
    bound: float,
    kind: int,
    layer: float,
    adapt: float,
    growth_max: float,
) -> None:
    """Advance the bounded integral of sgn, less the share by which it is held.

    With `adapt` [1/s] it is faster by a growth that rises outside the layer and falls inside it.
    """
    for i in range(memory.shape[1]):
        if held[i] < 1.0:
            advance = dt * (1.0 - held[i]) * soft_sign(s_qp_tangent[i], kind, layer)
            if adapt > 0.0:
                outside = min(abs(s_qp_tangent[i]) / layer, 2.0) - 1.0
                grown = memory[GROWTH, i] + dt * (1.0 - held[i]) * adapt * outside
                memory[GROWTH, i] = min(max(grown, 0.0), growth_max)
                advance *= 1.0 + memory[GROWTH, i]
            advanced = memory[INTEGRAL, i] + advance
            memory[INTEGRAL, i] = min(max(advanced, -bound), bound)


@compiled
def force_update(memory: np.ndarray, age: float, beta_F: float, k_iF: float) -> None:
    """Write s_qF, s_rF and ds_dF/dt at `age` = t - t0. Source: eq. (23a)-(23d), see the class."""
    forgotten = math.exp(-beta_F * age)
    for i in range(memory.shape[1]):
        s_dF = memory[S_F0, i] * forgotten
        memory[RATE_OF_S_DF, i] = -beta_F * s_dF
        memory[S_QF, i] = memory[S_F, i] - s_dF
        memory[S_RF, i] = memory[S_QF, i] + k_iF * memory[INTEGRAL_F, i]


@compiled
def force_integrate(
    memory: np.ndarray, dlam: np.ndarray, dt: float, kind: int, layer: float
) -> None:
    """Advance both integrals with the force error."""
    for i in range(memory.shape[1]):
        memory[INTEGRAL_F, i] += dt * soft_sign(memory[S_QF, i], kind, layer)
        memory[S_F, i] += dt * dlam[i]


@entrance
def posture_update_alone(
    memory: np.ndarray, dq: np.ndarray, dv: np.ndarray, age: float, alpha: float, beta_p: float,
    k_ip: float, root: float, layer: float,
) -> None:  # fmt: skip
    """Update a posture manifold, called from Python."""
    posture_update(memory, dq, dv, age, alpha, beta_p, k_ip, root, layer)


@entrance
def posture_integrate_alone(
    memory: np.ndarray, s_qp_tangent: np.ndarray, held: np.ndarray, dt: float, bound: float,
    kind: int, layer: float, adapt: float, growth_max: float,
) -> None:  # fmt: skip
    """Integrate a posture manifold, called from Python."""
    posture_integrate(memory, s_qp_tangent, held, dt, bound, kind, layer, adapt, growth_max)


@entrance
def force_update_alone(memory: np.ndarray, age: float, beta_F: float, k_iF: float) -> None:
    """Update a force manifold, called from Python."""
    force_update(memory, age, beta_F, k_iF)


@entrance
def force_integrate_alone(
    memory: np.ndarray, dlam: np.ndarray, dt: float, kind: int, layer: float
) -> None:
    """Integrate a force manifold, called from Python."""
    force_integrate(memory, dlam, dt, kind, layer)
