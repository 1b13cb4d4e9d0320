"""Rows of the dynamics: (1), (6), (8), regressor (18), skew symmetry, error dynamics (19), (25)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from equipoise.spatial import Array
from equipoise.verify.error_dynamics import (
    Dynamics,
    dynamic_parameters,
    error_force,
    force_error_drive,
    inertia,
    reference_regressor,
    regressor,
)
from equipoise.verify.evidence import DAMPING, Evidence
from equipoise.verify.flow import moment, rates
from equipoise.verify.row import Check, Measured, worst
from equipoise.verify.short_runs import RecordedRun, Sample

STEP = 1e-6


def applied(sample: Sample) -> Array:
    """Return `S^T tau` (nv,): no row of the base has a motor."""
    base = len(sample.measured.v) - len(sample.command.tau)
    return np.concatenate((np.zeros(base), sample.command.tau))


def _equation_of_motion(evidence: Evidence) -> Measured:
    """(1), (6): simulated a and lam in Pinocchio's inverse dynamics give back torque and wrench.

    With the law's torque spread as `S^T tau`: the base rows of the left-hand side have only
    contacts to balance them.
    """
    run, errors = evidence.moving_run(1e-3), []
    for index in evidence.spread_samples(1e-3, 20):
        sample = run.samples[index]
        J = run.contacts.jacobian(run.kinematics(sample))
        q, v = sample.measured.q, sample.measured.v
        data = run.robot.model.createData()
        needed = pin.rnea(run.robot.model, data, q, v, sample.a)
        damping = Dynamics.at(run.robot, q, v, DAMPING).D @ (v + run.dt * sample.a)
        errors.append(
            (needed + damping - applied(sample) - J.T @ sample.lam) / np.abs(needed).max()
        )
    return Measured(worst(errors), "along the run; joint damping taken implicitly, as simulated")


def _terms(evidence: Evidence) -> Measured:
    """(1): M a + C v + g against Pinocchio's recursive inverse dynamics."""
    generator, errors = evidence.generator(), []
    robot = evidence.robot
    for q, v in evidence.states:
        a = generator.normal(size=robot.nv)
        dynamics = Dynamics.at(robot, q, v)
        expected = pin.rnea(robot.model, robot.model.createData(), q, v, a)
        errors.append((dynamics.M @ a + dynamics.bias(v) - expected) / np.abs(expected).max())
    return Measured(worst(errors), "random states")


def _base_without_motor(evidence: Evidence) -> Measured:
    """The torque that is applied moves the robot as the fully actuated law u would."""
    run, errors = evidence.moving_run(1e-3), []
    for index in evidence.spread_samples(1e-3, 10):
        sample = run.samples[index]
        J = run.contacts.jacobian(run.kinematics(sample))
        M = Dynamics.at(run.robot, sample.measured.q, sample.measured.v, DAMPING)
        size = M.M + run.dt * M.D
        inverse_J = np.linalg.solve(size, J.T)
        difference = sample.command.u - applied(sample)
        lam = -np.linalg.lstsq(J @ inverse_J, J @ np.linalg.solve(size, difference), rcond=None)[0]
        acceleration = np.linalg.solve(size, difference + J.T @ lam)
        errors.append(acceleration / np.abs(sample.a).max())
        grasp = run.contacts.regulated_rows
        errors.append(lam[grasp] / np.abs(sample.lam).max())
    return Measured(worst(errors), "neither the motion nor the regulated force differs")


def _regressor(evidence: Evidence) -> Measured:
    """(18): Y Theta = M a + C v + g; and Y_r Theta with C at v acting on v_r."""
    generator, errors = evidence.generator(), []
    robot = evidence.robot
    theta = dynamic_parameters(robot)
    for q, v in evidence.states:
        a, v_r = generator.normal(size=(2, robot.nv))
        dynamics = Dynamics.at(robot, q, v)
        expected = pin.rnea(robot.model, robot.model.createData(), q, v, a)
        errors.append((regressor(robot, q, v, a) @ theta - expected) / np.abs(expected).max())
        wanted = dynamics.reference_force(v_r, a)
        given = reference_regressor(robot, q, v, v_r, a) @ theta
        errors.append((given - wanted) / np.abs(wanted).max())
    return Measured(worst(errors), f"{len(theta)} parameters, random states")


def _skew_symmetry(evidence: Evidence) -> Measured:
    """x^T (dM/dt - 2 C) x = 0 for any x, with C from the regressor; dM/dt by differences."""
    errors: list[ArrayLike] = []
    run = evidence.moving_run(1e-3)
    along = [run.samples[i].measured for i in evidence.spread_samples(1e-3, 10)]
    states = [*evidence.states, *((state.q, state.v) for state in along)]
    generator = evidence.generator()
    for q, v in states:
        M_rate, C = inertia_rate(evidence, q, v), Dynamics.at(evidence.robot, q, v).C
        scale = max(float(np.abs(M_rate).max()), float(np.abs(C).max()), 1e-3)
        errors.append((M_rate - C - C.T) / scale)
        errors.append(_skew_by_regressor(evidence, q, v, generator.normal(size=len(v)), M_rate))
    return Measured(worst(errors), "random states and states of the run, relative")


def _skew_by_regressor(evidence: Evidence, q: Array, v: Array, x: Array, M_rate: Array) -> float:
    robot, still = evidence.robot, np.zeros(len(v))
    theta = dynamic_parameters(robot)
    C_x = (reference_regressor(robot, q, v, x, still) - regressor(robot, q, still, still)) @ theta
    return float(x @ (M_rate @ x - 2.0 * C_x)) / max(float(np.abs(x * C_x).sum()), 1e-9)


def inertia_rate(evidence: Evidence, q: Array, v: Array) -> Array:
    """Return dM/dt (nv, nv) along `v` (nv,) by central differences."""
    robot = evidence.robot
    ahead, behind = (
        inertia(robot, pin.integrate(robot.model, q, s * STEP * v)) for s in (1.0, -1.0)
    )
    return (ahead - behind) / (2.0 * STEP)


def _open_loop_error(evidence: Evidence) -> Measured:
    """(19): M ds/dt + (C + D) s = S^T tau + J^T lam - Y_r Theta along runs of three steps."""
    return shrinking(evidence, _open_loop_residual)


def _open_loop_residual(evidence: Evidence, dt: float) -> float:
    run, errors = evidence.moving_run(dt), []
    theta = dynamic_parameters(run.robot)
    for index in evidence.spread_samples(dt, 10):
        sample = run.samples[index]
        q, v = sample.measured.q, sample.measured.v
        now, rate = moment(run, sample, 0.0), rates(run, sample)
        dynamics = Dynamics.at(run.robot, q, v, DAMPING)
        Y_r = reference_regressor(run.robot, q, v, now.v_r, rate.v_r)
        reference = Y_r @ theta + dynamics.D @ now.v_r
        J = run.contacts.jacobian(run.kinematics(sample))
        driven = applied(sample) + J.T @ sample.lam - reference
        errors.append((error_force(dynamics, now.s, rate.s) - driven) / np.abs(reference).max())
    return worst(errors)


def _closed_loop_error(evidence: Evidence) -> Measured:
    """(25), (26): M ds/dt + (C + D + K_d) s = J^T Z_F + J^T (rest) - Y_r Theta, in the tangent.

    The rest are the multipliers that are not regulated; they do no work on s.
    """
    return shrinking(evidence, _closed_loop_residual)


def _closed_loop_residual(evidence: Evidence, dt: float) -> float:
    run, errors = evidence.moving_run(dt), []
    theta = dynamic_parameters(run.robot)
    for index in evidence.spread_samples(dt, 10):
        sample = run.samples[index]
        q, v = sample.measured.q, sample.measured.v
        now, rate = moment(run, sample, 0.0), rates(run, sample, lam=sample.lam)
        dynamics = Dynamics.at(run.robot, q, v, DAMPING)
        Y_r = reference_regressor(run.robot, q, v, now.v_r, rate.v_r)
        reference = Y_r @ theta + dynamics.D @ now.v_r
        stacked = run.contacts.at(run.kinematics(sample))
        others = np.setdiff1d(np.arange(run.contacts.size), run.contacts.regulated_rows)
        J = stacked.J_phi
        drive = J[run.contacts.regulated_rows].T @ _drive(run, sample, rate.s_rF)
        left = error_force(dynamics, now.s, rate.s) + run.K_d @ now.s
        residual = left - drive + reference
        rest = np.linalg.lstsq(J[others].T, residual, rcond=None)[0]
        errors.append((residual - J[others].T @ rest) / np.abs(reference).max())
    return worst(errors)


def _drive(run: RecordedRun, sample: Sample, s_rF_rate: Array) -> Array:
    gains, force = run.gains, sample.after.force
    return force_error_drive(
        force.s_rF,
        s_rF_rate,
        force.s_qF,
        gains.sgn_F(force.s_qF),
        eta=gains.eta,
        k_iF=gains.k_iF,
        mu=gains.mu,
    )


def shrinking(evidence: Evidence, residual: Callable[[Evidence, float], float]) -> Measured:
    """Return the residual at 1 kHz; it must shrink with the step (implicit damping is O(h))."""
    coarse, middle, fine = (residual(evidence, dt) for dt in (2e-3, 1e-3, 5e-4))
    note = f"{coarse:.1e}, {middle:.1e}, {fine:.1e} at 2, 1, 0.5 ms"
    shrinks = fine < middle < coarse
    return Measured(middle if shrinks else np.inf, note + ("" if shrinks else ": does not shrink"))


CHECKS = (
    Check("(1)", "M a + C v + g is the inverse dynamics", "verify.error_dynamics.Dynamics", 1e-10,
          "", _terms),
    Check("(6), (8) row 1", "simulated a and lam solve the equation of motion with S^T tau",
          "physics.RigidContactEngine", 1e-7, "", _equation_of_motion),
    Check("base wrench", "the robot without motors on its base moves as the actuated law would",
          "control.distribute_base_wrench", 1e-8, "", _base_without_motor),
    Check("(18)", "Y Theta and Y_r Theta, linear in the parameters",
          "verify.error_dynamics.regressor", 1e-10, "", _regressor),
    Check("skew symmetry", "dM/dt - 2 C is skew", "verify.error_dynamics.reference_regressor", 1e-6,
          "", _skew_symmetry),
    Check("(19)", "open-loop error dynamics along runs", "verify.error_dynamics.error_force", 1e-3,
          "", _open_loop_error),
    Check("(25), (26)", "closed-loop error dynamics along runs",
          "control.PassivityController, verify.error_dynamics.force_error_drive", 1e-3, "",
          _closed_loop_error),
)  # fmt: skip
