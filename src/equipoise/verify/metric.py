"""Rows of the projector that is orthogonal in K_d: its identities, its energy, its cascade."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from equipoise.control import NearestVelocity, PassivityController
from equipoise.control.passivity.gain_advice import eigenvalues, handed_over
from equipoise.spatial import Array
from equipoise.verify import law, promises
from equipoise.verify.error_dynamics import inertia
from equipoise.verify.evidence import KAPPA, Evidence
from equipoise.verify.row import Check, Measured, worst


def _places(evidence: Evidence) -> Iterator[tuple[Array, Array, Array]]:
    """Yield contact rows, K_d and the inertia at states of the carrying run."""
    run = evidence.in_metric.moving_run(1e-3)
    for index in evidence.spread_samples(1e-3, 5):
        sample = run.samples[index]
        J = run.contacts.jacobian(run.kinematics(sample))
        yield J, run.K_d, inertia(evidence.robot, sample.measured.q)


def _identities(evidence: Evidence) -> Measured:
    """J N = 0, N N = N, J J^# = I, K N = K - J^T Lam J symmetric, J^#^T K N = 0; rank n - r."""
    errors: list[ArrayLike] = []
    for J, K, _ in _places(evidence):
        factor = NearestVelocity(J, K)
        N, J_sharp = factor.N, factor.J_sharp
        Lam = np.linalg.inv(J @ np.linalg.solve(K, J.T))
        size = np.abs(K).max()
        errors += [J @ N, N @ N - N, J @ J_sharp - np.eye(len(J))]
        errors += [(K @ N - K + J.T @ Lam @ J) / size, (K @ N - N.T @ K) / size]
        errors += [J_sharp.T @ K @ N / size, J_sharp - np.linalg.solve(K, J.T) @ Lam]
        errors += [[factor.rank + np.linalg.matrix_rank(N) - len(N)]]
    return Measured(worst(errors), "18 rows, 36 velocities, along the run; by numpy's inverses")


def _nearest(evidence: Evidence) -> Measured:
    """N x + J^# y is the minimum of |z - x| in K_d under J z = y, as its optimality says."""
    generator = evidence.generator()
    errors: list[ArrayLike] = []
    for J, K, _ in _places(evidence):
        x, y = generator.normal(size=(J.shape[1],)), generator.normal(size=(len(J),))
        r, n = J.shape
        optimum = np.block([[K, J.T], [J, np.zeros((r, r))]])
        z = np.linalg.solve(optimum, np.concatenate((K @ x, y)))[:n]
        errors.append(NearestVelocity(J, K).move(x, y) - z)
    return Measured(worst(errors), "against the linear system of its optimum")


def _redundant(evidence: Evidence) -> Measured:
    """Rows given twice change neither N nor the lift of what they agree on."""
    generator = evidence.generator()
    errors: list[ArrayLike] = []
    for J, K, _ in _places(evidence):
        mix = generator.normal(size=(4, len(J)))
        once, twice = NearestVelocity(J, K), NearestVelocity(np.vstack((J, mix @ J)), K)
        x, y = generator.normal(size=(J.shape[1],)), generator.normal(size=(len(J),))
        errors += [[once.rank - twice.rank], once.keep(x) - twice.keep(x)]
        errors.append(once.lift(y) - twice.lift(np.concatenate((y, mix @ y))))
    return Measured(worst(errors), "four sums of rows on top of 18")


def _energy_split(evidence: Evidence) -> Measured:
    """s^T K s = |N s_rp|_K^2 + beta^2 s_rF^T Lam s_rF: posture and force error do not mix."""
    run, errors = evidence.in_metric.moving_run(1e-3), []
    rows = run.contacts.regulated_rows
    for index in evidence.spread_samples(1e-3, 20):
        sample = run.samples[index]
        J = run.contacts.jacobian(run.kinematics(sample))
        s_rF = np.zeros(len(J))
        s_rF[rows] = sample.after.force.s_rF
        kept = run.tangent(J, sample.after.posture.s_rp)
        Lam = np.linalg.inv(J @ np.linalg.solve(run.K_d, J.T))
        whole = sample.command.s @ run.K_d @ sample.command.s
        parts = kept @ run.K_d @ kept + run.gains.beta**2 * s_rF @ Lam @ s_rF
        errors.append([(whole - parts) / whole])
    return Measured(worst(errors), "s as the law commanded it")


def _damps_supports(evidence: Evidence) -> Measured:
    """With damp_violation J s is J dv on supporting rows and -beta s_rF on regulated ones."""
    run = evidence.in_metric.moving_run(1e-3)
    gains = replace(run.gains, damp_violation=True)
    law_of = PassivityController(evidence.robot, run.contacts, gains, run.dt)
    generator, errors = evidence.generator(), []
    support, rows = run.contacts.supporting_rows, run.contacts.regulated_rows
    for sample in run.samples[:20]:
        v = sample.measured.v + 0.1 * generator.normal(size=evidence.robot.nv)
        measured = sample.measured._replace(v=v)
        s = law_of.step(sample.t, measured, sample.reference).s
        kin = evidence.robot.at(measured.q, v, sample.t)
        J = run.contacts.jacobian(kin)
        dv = v - law.carried(evidence.robot, sample.reference, measured.q)
        wanted = np.zeros(len(J))
        wanted[support] = (J @ dv)[support]
        wanted[rows] = -gains.beta * law_of.force.s_rF
        errors.append(J @ s - wanted)
    return Measured(worst(errors), "velocities that violate every contact by 0.1")


def _passive(evidence: Evidence) -> Measured:
    """v^T K N v >= 0 for every v, on the manifold and off it; K Q_phi is indefinite."""
    least, printed = [], []
    for J, K, _ in _places(evidence):
        KN = K @ NearestVelocity(J, K).N
        KQ = K @ (np.eye(len(K)) - np.linalg.pinv(J) @ J)
        least.append(eigenvalues(KN + KN.T, 2.0 * K)[0])
        printed.append(eigenvalues(KQ + KQ.T, 2.0 * K)[0])
    if min(printed) > -0.1:
        return Measured(np.inf, "Q_phi is not told from N here")
    return Measured(
        max(0.0, -min(least)),
        f"least eigenvalue against K_d: {min(least):.1g} with N, {min(printed):.2g} with Q_phi",
    )


def _no_faster(evidence: Evidence) -> Measured:
    """The fastest rate of H^-1 K N is at most that of H^-1 K, whatever K_d is.

    With the feet in the air and the base rows handed to them (P) neither is bounded by it; there
    Q_phi is faster by two orders of magnitude.
    """
    excess, handed, printed = [], [], []
    support, base = evidence.in_metric.contacts.supporting_rows, evidence.robot.nv_base
    for J, K, M in _places(evidence):
        fastest = float(eigenvalues(K, M)[-1])
        N, Q = NearestVelocity(J, K).N, np.eye(len(K)) - np.linalg.pinv(J) @ J
        P = handed_over(J[support], base)
        excess.append(np.abs(np.linalg.eigvals(np.linalg.solve(M, K @ N))).max() / fastest - 1.0)
        handed.append(np.abs(np.linalg.eigvals(np.linalg.solve(M, P @ K @ N))).max() / fastest)
        printed.append(np.abs(np.linalg.eigvals(np.linalg.solve(M, P @ K @ Q))).max() / fastest)
    note = f"feet in the air: {max(handed):.2f} times it with N, {max(printed):.0f} with Q_phi"
    return Measured(max(0.0, max(excess)), note)


def _cascade(evidence: Evidence) -> Measured:
    """K = kappa H: a contact force does not reach N v, so d(N v)/dt is the same on any floor."""
    generator, errors = evidence.generator(), []
    for J, _, M in _places(evidence):
        factor = NearestVelocity(J, KAPPA * M)
        lam = generator.normal(size=(len(J),))
        pushed = np.asarray(np.linalg.solve(M, J.T @ lam), dtype=float)
        errors.append(factor.keep(pushed) / np.abs(pushed).max())
    return Measured(worst(errors), "N H^-1 J^T lam, any lam")


def _under(measure: Callable[[Evidence], Measured]) -> Callable[[Evidence], Measured]:
    """Return a measurement of the law made again with this projector."""
    return lambda evidence: measure(evidence.in_metric)


_AGAIN = (
    ("(20)", law.CHECKS), ("(21)", law.CHECKS), ("(22)", law.CHECKS), ("(24)", law.CHECKS),
    ("(28)", law.CHECKS), ("(29)", law.CHECKS), ("boundedness", law.CHECKS),
    ("passivity", law.CHECKS), ("model-free", law.CHECKS), ("sliding", promises.CHECKS),
    ("reaching", promises.CHECKS), ("posture promise", promises.CHECKS),
)  # fmt: skip


def _again() -> tuple[Check, ...]:
    """Return the rows of the law and its promises that are owed with any projector."""
    found = []
    for key, checks in _AGAIN:
        check = next(c for c in checks if c.key == key)
        found.append(replace(check, key=f"N {key}", measure=_under(check.measure)))
    return tuple(found)


CHECKS = (
    Check("N", "J N = 0, N N = N, K N = N^T K >= 0, J J^# = I", "control.NearestVelocity", 1e-8,
          "", _identities),
    Check("N nearest", "N x + J^# y is nearest to x in K_d with J z = y",
          "control.NearestVelocity", 1e-8, "m/s, rad/s", _nearest),
    Check("N redundancy", "rows given twice change nothing", "control.NearestVelocity", 1e-7,
          "m/s, rad/s", _redundant),
    Check("N split", "s^T K s = |N s_rp|^2 + beta^2 s_rF^T Lam s_rF",
          "control.PassivityController", 1e-9, "", _energy_split),
    Check("N supports", "J s damps what violates supports, and nothing else",
          "control.PassivityController", 1e-9, "m/s, rad/s", _damps_supports),
    Check("N passive", "-v^T K N v <= 0 off the manifold too", "control.NearestVelocity", 1e-9, "",
          _passive),
    Check("N rate", "no rate of H^-1 K N above the fastest of H^-1 K", "control.NearestVelocity",
          1e-9, "", _no_faster),
    Check("N cascade", "N H^-1 J^T = 0 for K = kappa H: the floor does not reach the posture",
          "control.NearestVelocity", 1e-9, "", _cascade),
    *_again(),
)  # fmt: skip
