"""Rows of the law: nominal reference (20)-(21), manifolds (22)-(23), torque (24), V (27)-(29)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.control import PassivityController, Reference
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.verify.dynamics import applied, shrinking
from equipoise.verify.error_dynamics import Dynamics, PowerBalance, inertia, lyapunov, power_balance
from equipoise.verify.evidence import STEPS, Evidence
from equipoise.verify.flow import moment, rates
from equipoise.verify.row import Check, Measured, worst
from equipoise.verify.short_runs import RecordedRun


def _nominal_reference(evidence: Evidence) -> Measured:
    """(20): v - v_r, put together by the printed formula with numpy, is the law's s."""
    errors = []
    for dt in STEPS:
        run = evidence.moving_run(dt)
        for index in evidence.spread_samples(dt, 10):
            sample = run.samples[index]
            now = moment(run, sample, 0.0)
            errors.append(sample.measured.v - now.v_r - sample.command.s)
    return Measured(worst(errors), "runs of three steps")


def _extended_error(evidence: Evidence) -> Measured:
    """(21): s against Q s_rp - J^+ beta s_rF; and s^T J^T = -beta s_rF^T."""
    run, errors = evidence.moving_run(1e-3), []
    rows = run.contacts.regulated_rows
    for sample in run.samples[::20]:
        J = run.contacts.jacobian(run.kinematics(sample))
        J_pinv, s_rF = run.right_inverse(J), np.zeros(len(J))
        s_rF[rows] = sample.after.force.s_rF
        s_rp = sample.after.posture.s_rp
        expected = s_rp - J_pinv @ (J @ s_rp) - J_pinv @ (run.gains.beta * s_rF)
        errors += [sample.command.s - expected, J @ sample.command.s + run.gains.beta * s_rF]
    return Measured(worst(errors), "and s^T J_phi^T = -beta s_rF^T, along the run")


def _posture_manifold(evidence: Evidence) -> Measured:
    """(22): the four lines recomputed from the recorded states alone, integral included."""
    run = evidence.moving_run(1e-3)
    gains, errors = run.gains, []
    first = run.samples[0].before.posture
    integral, s_p0 = first.integral_of_sign.copy(), first.s_p0
    for sample in run.samples:
        state, reference = sample.measured, sample.reference
        dq = pin.difference(run.robot.model, reference.q_ref, state.q)
        s_p = state.v - carried(run.robot, reference, state.q) + gains.alpha * dq
        s_qp = s_p - s_p0 * np.exp(-gains.beta_p * sample.t)
        errors.append(sample.after.posture.s_rp - (s_qp + gains.k_ip * integral))
        J = run.contacts.jacobian(run.kinematics(sample))
        tangent = run.tangent(J, s_qp)
        integral = integral + run.dt * np.clip(tangent / gains.sgn_p.layer, -1.0, 1.0)
    return Measured(worst(errors), f"{len(run.samples)} ticks, sgn as a saturation")


def carried(robot: Robot, reference: Reference, q: Array) -> Array:
    """Return v_ref with its base twist as seen from the base at `q`, by action matrices."""
    of_q, of_v = slice(robot.nq_base), slice(robot.nv_base)
    base, base_ref = pin.XYZQUATToSE3(q[of_q]), pin.XYZQUATToSE3(reference.q_ref[of_q])
    v = reference.v_ref.copy()
    v[of_v] = (base.inverse() * base_ref).toActionMatrix() @ v[of_v]
    return v


def _force_manifold(evidence: Evidence) -> Measured:
    """(23): the four lines recomputed from the recorded multipliers alone."""
    run = evidence.moving_run(1e-3)
    gains, rows, errors = run.gains, run.contacts.regulated_rows, []
    first = run.samples[0].before.force
    s_F, integral = first.s_F.copy(), first.integral_of_sign.copy()
    for sample in run.samples:
        s_qF = s_F - first.s_F0 * np.exp(-gains.beta_F * sample.t)
        errors.append(sample.after.force.s_rF - (s_qF + gains.k_iF * integral))
        integral = integral + run.dt * np.clip(s_qF / gains.sgn_F.layer, -1.0, 1.0)
        s_F = s_F + run.dt * (sample.measured.lam[rows] - sample.reference.lam_ref)
    return Measured(worst(errors), f"{len(run.samples)} ticks; see also the force promise")


def _torque(evidence: Evidence) -> Measured:
    """(24): u put together from its parts; the applied torque is u less J_r^T F."""
    run, errors = evidence.moving_run(1e-3), []
    gains, rows, support = run.gains, run.contacts.regulated_rows, run.contacts.supporting_rows
    for sample in run.samples[::10]:
        J = run.contacts.jacobian(run.kinematics(sample))
        force = sample.after.force
        s_dF_rate = -gains.beta_F * force.s_F0 * np.exp(-gains.beta_F * sample.t)
        along = -sample.reference.lam_ref - s_dF_rate + gains.k_iF * np.tanh(gains.mu * force.s_qF)
        along = along + gains.eta * force.s_rF
        u = -run.K_d @ sample.command.s + J[rows].T @ along
        errors.append((sample.command.u - u) / np.abs(u).max())
        carried = u - J[support].T @ sample.command.base_reaction - applied(sample)
        errors.append(carried / np.abs(u).max())
    return Measured(worst(errors), "no tick saturated; the base rows vanish")


@dataclass(frozen=True)
class Energy:
    """V and its rate at one sample, twice: along the flow of the code, and by the terms of (28).

    `s_size` is `sqrt(s^T K s)` and `drive_size` `sqrt(delta^T K^-1 delta)` with K = K_d + D, so
    that `s^T delta <= s_size drive_size`.
    """

    t: float
    V: float
    V_rate: float
    terms: PowerBalance
    s_size: float
    drive_size: float


def energies(run: RecordedRun, indices: list[int]) -> list[Energy]:
    """Return the energy balance at chosen ticks of a run."""
    found = []
    for index in indices:
        sample = run.samples[index]
        state, force, gains = sample.measured, sample.after.force, run.gains
        now, rate = moment(run, sample, 0.0), rates(run, sample)
        dynamics = Dynamics.at(run.robot, state.q, state.v, run.joint_damping)
        reference = dynamics.reference_force(now.v_r, rate.v_r)
        sign = gains.sgn_F(force.s_qF)
        terms = power_balance(
            dynamics, gains, now.s, reference, s_rF=force.s_rF, s_qF=force.s_qF, sign=sign
        )
        J = run.contacts.jacobian(run.kinematics(sample))[run.contacts.regulated_rows]
        mismatch = gains.k_iF * (np.tanh(gains.mu * force.s_qF) - sign)
        drive, K = reference - J.T @ mismatch, run.K_d + dynamics.D
        drive_size = float(np.sqrt(drive @ np.linalg.solve(K, drive)))
        s_size = float(np.sqrt(now.s @ K @ now.s))
        found.append(Energy(sample.t, now.V, rate.V, terms, s_size, drive_size))
    return found


def _lyapunov(evidence: Evidence) -> Measured:
    """(27): V against the kinetic energy of a robot that moves with s, plus the force part."""
    run, errors = evidence.moving_run(1e-3), []
    for index in evidence.spread_samples(1e-3, 10):
        sample = run.samples[index]
        s, s_rF = sample.command.s, sample.after.force.s_rF
        V = lyapunov(inertia(run.robot, sample.measured.q), s, s_rF, run.gains.beta)
        data = run.robot.model.createData()
        kinetic = pin.computeKineticEnergy(run.robot.model, data, sample.measured.q, s)
        expected = kinetic + 0.5 * run.gains.beta * float(s_rF @ s_rF)
        errors.append([(V - expected) / expected, min(V, 0.0)])
    return Measured(worst(errors), "and V > 0, along the run")


def _power_identity(evidence: Evidence) -> Measured:
    """(28): dV/dt along the flow of law and physics against the terms, at three steps."""
    return shrinking(evidence, _power_residual)


def _power_residual(evidence: Evidence, dt: float) -> float:
    run = evidence.moving_run(dt)
    balance = energies(run, evidence.spread_samples(dt, 40))
    gaps = np.array([e.V_rate - e.terms.rate for e in balance])
    sizes = np.array([e.terms.throughput for e in balance])
    return float(np.sqrt(np.mean(gaps**2) / np.mean(sizes**2)))


def _power_bound(evidence: Evidence) -> Measured:
    """(29): dV/dt <= -s^T (D + K_d) s - beta eta |s_rF|^2 + |s|_K |delta|_K^-1."""
    excess = []
    for e in energies(evidence.moving_run(1e-3), evidence.spread_samples(1e-3, 40)):
        bound = e.s_size * e.drive_size
        bound -= e.terms.motion_dissipation + e.terms.force_dissipation
        excess.append(max(0.0, e.V_rate - bound) / e.terms.throughput)
    return Measured(worst([excess]), "delta is Y_r Theta and what the signs differ by, as measured")


def _bounded(evidence: Evidence) -> Measured:
    """After (29): V falls wherever s is outside the region that delta allows.

    Sizes are measured by K = K_d + D, which makes the region tight: s^T K s > delta^T K^-1 delta.
    A blow throws the robot out of the region; the carrying run stays inside.
    """
    outside, growing, top = 0, 0.0, 0.0
    for run in (evidence.kicked_run(), evidence.moving_run(1e-3)):
        ticks = [*range(20), *range(20, len(run.samples), 15)]
        for e in energies(run, ticks):
            top = max(top, e.V)
            if e.s_size > e.drive_size:
                outside += 1
                growing = max(growing, e.V_rate)
    note = f"V <= {top:.3g} J; in {outside} samples outside, V falls in each"
    return Measured(max(growing, 0.0) if outside else np.inf, note)


def _passivity(evidence: Evidence) -> Measured:
    """(25) as a passive map: V(t1) - V(t0) + dissipated = energy fed in, by quadrature."""
    return shrinking(evidence, _balance_residual)


def _balance_residual(evidence: Evidence, dt: float) -> float:
    run = evidence.moving_run(dt)
    ticks = [i for i, s in enumerate(run.samples) if 0.20 <= s.t <= 0.30]
    balance = energies(run, ticks)
    times = np.array([e.t for e in balance])
    stored = balance[-1].V - balance[0].V
    fed = np.trapezoid([e.terms.disturbance + e.terms.sign_mismatch for e in balance], times)
    lost = np.trapezoid(
        [e.terms.motion_dissipation + e.terms.force_dissipation for e in balance], times
    )
    return abs(stored + lost - fed) / (abs(stored) + abs(fed) + lost)


def _blind(evidence: Evidence) -> Measured:
    """The law gives the same torque, bit for bit, to a robot with other masses and inertias."""
    nominal, robot = evidence.moving_run(1e-3), evidence.robot
    laws = [
        PassivityController(body, nominal.contacts, nominal.gains, nominal.dt)
        for body in (robot, robot.with_unit_inertias())
    ]
    errors = []
    for sample in nominal.samples[:100]:
        first, second = (law.step(sample.t, sample.measured, sample.reference).tau for law in laws)
        errors.append(first - second)
    return Measured(worst(errors), "every link of mass 1 kg and inertia 1 kg m2, 100 ticks")


CHECKS = (
    Check("(20)", "v - v_r of the printed nominal reference is s",
          "control.PassivityController", 1e-9, "m/s, rad/s", _nominal_reference),
    Check("(21)", "s = Q s_rp - J^+ beta s_rF, and s^T J^T = -beta s_rF^T",
          "control.PassivityController", 1e-9, "m/s, rad/s", _extended_error),
    Check("(22)", "posture manifold from recorded states", "control.PostureManifold", 1e-7,
          "m/s, rad/s", _posture_manifold),
    Check("(23)", "force manifold from recorded multipliers", "control.ForceManifold", 1e-9, "N s",
          _force_manifold),
    Check("(24)", "the law from its parts, torque on the joints only",
          "control.PassivityController", 1e-9, "", _torque),
    Check("model-free", "the torque does not depend on masses and inertias",
          "control.PassivityController", 0.0, "N m", _blind),
    Check("(27)", "V is an energy", "verify.error_dynamics.lyapunov", 1e-10, "", _lyapunov),
    Check("(28)", "both sides of dV/dt along runs", "verify.error_dynamics.power_balance", 1e-3, "",
          _power_identity),
    Check("(29)", "the bound on dV/dt", "verify.error_dynamics.power_balance", 1e-6, "",
          _power_bound),
    Check("boundedness", "V falls wherever |s| is outside the region of delta",
          "control.PassivityController", 1e-6, "W", _bounded),
    Check("passivity", "energy fed in = stored + dissipated, along runs",
          "control.PassivityController", 1e-2, "", _passivity),
)  # fmt: skip
