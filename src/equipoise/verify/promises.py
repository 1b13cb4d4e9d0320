"""Rows of the claims: sliding mode, exponential convergence of posture and force, smooth torque."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.control import PassivityController, SignFunction
from equipoise.spatial import Array
from equipoise.verify.closed_forms import force_error, posture_error
from equipoise.verify.evidence import KAPPA, Evidence
from equipoise.verify.flow import rates
from equipoise.verify.row import Check, Measured
from equipoise.verify.short_runs import Plan, moving_reference, record, still_reference

PROMISE_STEPS = (1e-3, 5e-4, 2.5e-4)  # [s]
POSTURE_GAINS = ((20.0, 5.0), (10.0, 10.0), (5.0, 8.0))  # alpha, beta_p [1/s]
FORCE_GAINS = ((10.0, 1.5), (6.0, 2.5))  # beta_F [1/s], s_F(t0) [N s]


def _posture_promise(evidence: Evidence) -> Measured:
    """From 0.2 rad in one arm every component of dq follows the closed form.

    The law starts without knowing gravity. K_d is the adviser's share of what the step allows, so
    that a shorter step allows a stiffer law.
    """
    table = [
        [_posture_deviation(evidence, alpha, beta_p, dt) for dt in PROMISE_STEPS]
        for alpha, beta_p in POSTURE_GAINS
    ]
    return _judge_steps(np.array(table), POSTURE_GAINS, "alpha, beta_p")


def _posture_deviation(evidence: Evidence, alpha: float, beta_p: float, dt: float) -> float:
    robot = evidence.robot
    start = np.zeros(robot.nv)
    start[robot.nv_base + robot.joint_index("LARM_JOINT3")] = 0.2
    run = record(
        robot,
        evidence.soles,
        still_reference(robot),
        Plan(
            dt=dt,
            duration=0.35,
            gains={
                "projector": evidence.projector,
                "alpha": alpha,
                "beta_p": beta_p,
                "k_ip": 20.0,
                "sgn_p": SignFunction("saturation", 0.1),
            },
            dq_start=start,
            keep_every=3,
        ),
    )
    deviations = []
    for sample in run.samples:
        dq = pin.difference(robot.model, robot.q_half_sitting, sample.measured.q)
        deviations.append(np.abs(dq - posture_error(sample.t, start, alpha * start, alpha, beta_p)))
    return float(np.max(deviations)) / 0.2


def _force_promise(evidence: Evidence) -> Measured:
    """A running integral s_F(t0) makes dlam follow -beta_F s_F(t0) exp(-beta_F (t - t0)).

    The force steps by beta_F s_F(t0) at t0 and dies from there; it starts when the integrals
    have found gravity, and with (eta + k_iF mu + beta kappa Lambda) dt small, as the law sees a
    force one tick late.
    """
    table = [
        [_force_deviation(evidence, beta_F, s_F0, dt) for dt in PROMISE_STEPS]
        for beta_F, s_F0 in FORCE_GAINS
    ]
    return _judge_steps(np.array(table), FORCE_GAINS, "beta_F, s_F(t0)")


def _force_deviation(evidence: Evidence, beta_F: float, s_F0: float, dt: float) -> float:
    begin = round(0.4 / dt)

    def restart(law: PassivityController) -> None:
        law.force.s_F = law.force.s_F + s_F0
        law.force.start(begin * dt)

    run = record(
        evidence.robot,
        evidence.contacts,
        still_reference(evidence.robot),
        Plan(
            dt=dt,
            duration=0.55,
            gains={
                "projector": evidence.projector,
                "k_ip": 20.0,
                "sgn_p": SignFunction("saturation", 0.1),
                "sgn_F": SignFunction("saturation", 0.5),
                "beta_F": beta_F,
                "k_iF": 2.0,
                "eta": 5.0,
                "mu": 1.0,
                "beta": 0.005,
            },
            kappa=KAPPA,
            events={begin: restart},
            keep_from=begin,
            keep_every=2,
        ),
    )
    rows = run.contacts.regulated_rows
    deviations = [
        sample.lam[rows]
        - sample.reference.lam_ref
        - force_error(sample.t - begin * dt, sample.after.force.s_F0, beta_F)
        for sample in run.samples
    ]
    return float(np.abs(deviations).max()) / (beta_F * s_F0)


def _judge_steps(table: Array, settings: Sequence[tuple[float, float]], names: str) -> Measured:
    """Return the largest deviation over all settings and steps, if each shrinks with the step."""
    shrinks = bool((np.diff(table, axis=1) < 0.0).all())
    shown = "; ".join(
        f"{setting}: " + ", ".join(f"{100 * value:.2f}" for value in row) + " %"
        for setting, row in zip(settings, table, strict=True)
    )
    steps = ", ".join(f"{1e3 * dt:g}" for dt in PROMISE_STEPS)
    note = f"({names}) at {steps} ms: {shown}" + ("" if shrinks else "; does not shrink")
    return Measured(float(table.max()) if shrinks else np.inf, note)


def _sliding(evidence: Evidence) -> Measured:
    """s_q ds_q/dt < 0 in every component outside the layer whose |ds_r/dt| is below k."""
    run = evidence.kicked_run()
    largest, checked, excused = -np.inf, 0, 0
    for sample in run.samples:
        rate = rates(run, sample)
        J = run.contacts.jacobian(run.kinematics(sample))
        s_q = run.tangent(J, sample.after.posture.s_qp)
        slope, demand = rate.s_qp, rate.s_rp
        outside = np.abs(s_q) > run.gains.sgn_p.layer
        able = np.abs(demand) < run.gains.k_ip
        checked += int((outside & able).sum())
        excused += int((outside & ~able).sum())
        products = (s_q * slope)[outside & able]
        if products.size:
            largest = max(largest, float(products.max()))
    note = f"{checked} components outside the layer; in {excused} more delta >= k, no promise"
    return Measured(max(largest, 0.0) if checked else np.inf, note)


def _reaching(evidence: Evidence) -> Measured:
    """The layer is reached within |s_q(t0)| / (k - delta), delta as measured until then."""
    run = evidence.kicked_run()
    gains, delta, first = run.gains, 0.0, None
    for sample in run.samples:
        J = run.contacts.jacobian(run.kinematics(sample))
        s_q = run.tangent(J, sample.after.posture.s_qp)
        size = float(np.abs(s_q).max())
        first = (sample.t, size) if first is None else first
        if size <= gains.sgn_p.layer:
            bound = first[1] / (gains.k_ip - delta) if delta < gains.k_ip else np.inf
            took = sample.t - first[0]
            note = f"took {1e3 * took:.1f} ms of at most {1e3 * bound:.1f}; delta {delta:.0f} < k"
            return Measured(took / bound if np.isfinite(bound) else np.inf, note)
        outside = np.abs(s_q) > gains.sgn_p.layer
        delta = max(delta, float(np.abs(rates(run, sample).s_rp[outside]).max()))
    return Measured(np.inf, "the layer was not reached")


def _delta(evidence: Evidence) -> Measured:
    """delta = sup |ds_r/dt| along the carrying run against k, once gravity has been found."""
    run = evidence.moving_run(1e-3)
    early, late, sizes = 0.0, 0.0, 0.0
    for index in evidence.spread_samples(1e-3, 80):
        sample = run.samples[index]
        J = run.contacts.jacobian(run.kinematics(sample))
        size = float(np.abs(run.tangent(J, rates(run, sample).s_rp)).max())
        if sample.t < 0.2:
            early = max(early, size)
        else:
            late = max(late, size)
            sizes = max(sizes, float(np.abs(sample.after.posture.s_qp).max()))
    k = run.gains.k_ip
    note = f"delta {late:.2g} < k {k:g} rad/s2 after 0.2 s, |s_q| <= {sizes:.2g}"
    note += f"; while gravity is unknown delta is {early:.2g}: no promise then"
    return Measured(late / k, note)


def _continuous(evidence: Evidence) -> Measured:
    """Halving the step halves the largest jump of the torque, even with the bare sign."""
    jumps = []
    for dt in PROMISE_STEPS:
        run = record(
            evidence.robot,
            evidence.contacts,
            moving_reference(evidence.robot, evidence.contacts, dt, 0.25),
            Plan(
                dt=dt,
                duration=0.25,
                gains={
                    "k_ip": 5.0,
                    "sgn_p": SignFunction("sign", 0.0),
                    "sgn_F": SignFunction("sign", 0.0),
                },
                kappa=100.0,
            ),
        )
        u = np.array([sample.command.u for sample in run.samples if sample.t > 0.05])
        jumps.append(float(np.abs(np.diff(u, axis=0)).max()))
    ratio = max(jumps[1] / jumps[0], jumps[2] / jumps[1])
    shown = ", ".join(f"{jump:.2g}" for jump in jumps)
    return Measured(ratio, f"largest change of u in a tick: {shown} N m at 1, 0.5, 0.25 ms")


CHECKS = (
    Check("sliding", "s_q . ds_q/dt < 0 outside the layer where delta < k",
          "control.PostureManifold", 0.0, "rad2/s3", _sliding),
    Check("reaching", "the layer is reached within |s_q| / (k - delta)",
          "control.PostureManifold", 1.0, "of the bound", _reaching),
    Check("delta < k", "the premise of the proof", "control.ControlGains", 1.0, "of k", _delta),
    Check("posture promise", "dq follows the closed form, three gains, three steps",
          "verify.closed_forms.posture_error", 0.01, "of dq(t0)", _posture_promise),
    Check("force promise", "dlam follows the closed form, two gains, three steps",
          "verify.closed_forms.force_error", 0.01, "of dlam(t0)", _force_promise),
    Check("continuity", "halving the step halves the largest jump of the torque",
          "control.PassivityController", 0.75, "ratio", _continuous),
)  # fmt: skip
