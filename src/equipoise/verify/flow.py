"""The law followed along the flow of a run: its own code, displaced by a little time both ways.

Velocity, acceleration, references and the integrals carry state and memory `span` [s] ahead and
back; the law is then asked again. What comes out is a derivative of what the code does, without a
formula for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.control import Measurement, PassivityController, Reference
from equipoise.spatial import Array, velocity_transport
from equipoise.verify.error_dynamics import inertia, lyapunov
from equipoise.verify.short_runs import RecordedRun, Sample, snapshot

SPAN = 2e-6  # [s] balances rounding and truncation of a central difference


@dataclass(frozen=True)
class Moment:
    """The law at one displaced instant: s (nv,), s_rF and s_rp, V, and v_r by eq. (20)."""

    s: Array
    s_rp: Array
    s_qp: Array
    s_rF: Array
    V: float
    v_r: Array


@dataclass(frozen=True)
class Rates:
    """Time derivatives of the fields of `Moment` along the flow."""

    s: Array
    s_rp: Array
    s_qp: Array
    s_rF: Array
    V: float
    v_r: Array


def rates(run: RecordedRun, sample: Sample, *, lam: Array | None = None) -> Rates:
    """Return derivatives along the flow at a sample.

    With `lam` (r,) the force integral advances with that multiplier, otherwise with the one that
    the law measured, which is a tick old.
    """
    ahead, behind = (moment(run, sample, sign * SPAN, lam=lam) for sign in (1.0, -1.0))
    return Rates(
        **{
            name: (getattr(ahead, name) - getattr(behind, name)) / (2.0 * SPAN)
            for name in Rates.__dataclass_fields__
        }
    )


def moment(run: RecordedRun, sample: Sample, span: float, *, lam: Array | None = None) -> Moment:
    """Return the law `span` [s] after a sample (before it, if negative)."""
    model, measured, reference = run.robot.model, sample.measured, sample.reference
    forward = measured.v * span + 0.5 * sample.a * span * span
    q = pin.integrate(model, measured.q, forward)
    v = measured.v + sample.a * span
    q_ref = pin.integrate(model, reference.q_ref, reference.v_ref * span)
    law = _displaced(run, sample, span, lam)
    displaced = Reference(q_ref, reference.v_ref + sample.a_ref * span, reference.lam_ref)
    command = law.step(sample.t + span, Measurement(q, v, measured.lam), displaced)
    s_rF = np.zeros(run.contacts.size)
    s_rF[run.contacts.regulated_rows] = law.force.s_rF
    return Moment(
        command.s,
        law.posture.s_rp,
        law.posture.s_qp,
        law.force.s_rF,
        lyapunov(inertia(run.robot, q), command.s, law.force.s_rF, run.gains.beta),
        nominal_reference(run, sample.t + span, q, v, displaced, law, s_rF),
    )


def nominal_reference(
    run: RecordedRun,
    t: float,
    q: Array,
    v: Array,
    reference: Reference,
    law: PassivityController,
    s_rF: Array,
) -> Array:
    """Return the nominal reference `v_r` (nv,), with numpy's inverses.

    Source: eq. (20). Differs from the print: v_ref is carried to the actual base axes, and what
    the velocity itself violates (`J^+ J v`, zero on a rigid contact at rest, the speed of the
    contact on a moving one) is added, so that `v - v_r` is (21) whatever v is.
    """
    gains, posture = run.gains, law.posture
    J = run.contacts.jacobian(run.robot.at(q, v, t))
    J_pinv = run.right_inverse(J)
    dq = pin.difference(run.robot.model, reference.q_ref, q)
    s_dp = posture.s_p0 * np.exp(-gains.beta_p * (t - posture.t0))
    wanted = velocity_transport(q, reference.q_ref, reference.v_ref) - gains.alpha * dq + s_dp
    wanted = wanted - gains.k_ip * posture_integral(law)
    tangent = wanted - J_pinv @ (J @ wanted)
    return tangent + J_pinv @ (gains.beta * s_rF) + J_pinv @ (J @ v)


def posture_integral(law: PassivityController) -> Array:
    """Return the integral of sgn that the law used in its last step (nv,)."""
    return (law.posture.s_rp - law.posture.s_qp) / law.posture.k_ip


def _displaced(
    run: RecordedRun, sample: Sample, span: float, lam: Array | None
) -> PassivityController:
    law, share = snapshot(sample.before), span / run.dt
    before, after = sample.before, sample.after
    law.posture.integral_of_sign = before.posture.integral_of_sign + share * (
        after.posture.integral_of_sign - before.posture.integral_of_sign
    )
    law.force.integral_of_sign = before.force.integral_of_sign + share * (
        after.force.integral_of_sign - before.force.integral_of_sign
    )
    if lam is None:
        slope = (after.force.s_F - before.force.s_F) / run.dt
    else:
        slope = lam[run.contacts.regulated_rows] - sample.reference.lam_ref
    law.force.s_F = before.force.s_F + span * slope
    return law
