"""Rows of the map at a switch of supports: continuous torque, the energy it costs, touchdown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from equipoise.contacts import ContactStack, SoleContact
from equipoise.control import (
    ControlGains,
    Keep,
    Measurement,
    PassivityController,
    Projector,
    Reference,
    SignFunction,
)
from equipoise.control.passivity.gain_advice import eigenvalues, null_space
from equipoise.physics import RigidContactEngine
from equipoise.spatial import Array
from equipoise.verify.error_dynamics import inertia
from equipoise.verify.evidence import KAPPA, Evidence
from equipoise.verify.row import Check, Measured, worst

DT = 1e-3
LEAN = 0.04  # [rad] by which the ankles lean over a foot, so that the other one is lighter
STEP = 0.15  # [rad] by which the hips swing at the end of a step of 0.2 m
SMALL = 1e-3
PROJECTORS: tuple[Projector, ...] = ("damping", "euclidean")


@dataclass(frozen=True)
class Loss:
    """A robot at rest on two soles, one of which loses its floor; then the first tick on the other.

    `lam` (12,) acted before, `tau` (na,) then and `before` before; `s` (nv,) of the tick, `J` (12,
    nv) of both soles, `H` (nv, nv) the inertia, `a` (nv,) how the robot sets off.
    """

    lam: Array
    before: Array
    tau: Array
    s: Array
    J: Array
    H: Array
    a: Array


def _posture(evidence: Evidence) -> Array:
    """Return half-sitting, leant to the left by ankles and hips, feet flat."""
    robot = evidence.robot
    dq = np.zeros(robot.nv)
    for side in ("L", "R"):
        for joint, turn in (("1", LEAN), ("5", -LEAN)):
            dq[robot.nv_base + robot.joint_index(f"{side}LEG_JOINT{joint}")] = turn
    return pin.integrate(robot.model, robot.q_half_sitting, dq)


def _law(
    evidence: Evidence, stack: ContactStack, H: Array, projector: Projector
) -> PassivityController:
    """Return a law with K_d = kappa H."""
    gains = ControlGains(
        K_d=KAPPA * H, k_ip=20.0, sgn_p=SignFunction("saturation", 0.1), projector=projector,
        integral_max=1e3,
    )  # fmt: skip
    return PassivityController(evidence.robot, stack, gains, DT)


def _lose(evidence: Evidence, keep: Keep, projector: Projector) -> Loss:
    """Let the right sole of a robot at rest lose its floor, as a tick of the law answers it."""
    robot, q = evidence.robot, _posture(evidence)
    kin = robot.at(q)
    soles = [SoleContact.standing(sole, kin) for sole in robot.soles]
    both, one = ContactStack(soles), ContactStack(soles[:1])
    H, J = inertia(robot, q), both.jacobian(kin)
    law, still = _law(evidence, both, H, projector), np.zeros(robot.nv)
    engine = RigidContactEngine(robot, both, q, DT)
    reference = Reference(q, still, np.zeros(0))
    law.take_over(engine.stand())
    lam = engine.state.lam
    for tick in range(2):
        force = np.concatenate((np.zeros(robot.nv_base), law.tau if tick else engine.stand()))
        lam = engine.accelerations(force)[1]
        before = law.step(tick * DT, Measurement(q, still, lam), reference).tau
    law.switch(one, keep)
    command = law.step(2 * DT, Measurement(q, still, lam[:6]), reference)
    alone = RigidContactEngine(robot, one, q, DT)
    a, _ = alone.accelerations(np.concatenate((np.zeros(robot.nv_base), command.tau)))
    return Loss(lam, before, command.tau, command.s, J, H, a)


def _continuous(evidence: Evidence) -> Measured:
    """The torque before and after a loss, a touchdown and a held object, in both projectors."""
    errors: list[ArrayLike] = []
    for projector in PROJECTORS:
        for law, then, lam, q, v in _runs(evidence, projector):
            tau = law.tau.copy()
            law.switch(then)
            wanted = np.full(then.regulated_rows.size, 20.0)
            reference = Reference(evidence.robot.q_half_sitting, np.zeros(len(v)), wanted)
            now = law.step(law.posture.t0 + 1.0, Measurement(q, v, lam), reference).tau
            errors.append((now - tau) / np.abs(tau).max())
    return Measured(worst(errors), "lift-off, touchdown and both with a held object, moving")


def _absorbed(evidence: Evidence) -> Measured:
    """What is handed over lies along the rows of hands: integral and F+ take all else."""
    errors: list[ArrayLike] = []
    for projector in PROJECTORS:
        for law, then, lam, q, v in _runs(evidence, projector):
            law.switch(then)
            wanted = np.full(then.regulated_rows.size, 20.0)
            reference = Reference(evidence.robot.q_half_sitting, np.zeros(len(v)), wanted)
            u = law.step(law.posture.t0 + 1.0, Measurement(q, v, lam), reference).u
            hands = np.setdiff1d(np.arange(then.size), then.supporting_rows)
            J = then.jacobian(evidence.robot.at(q, v))[hands]
            rest = law.handover - J.T @ np.linalg.lstsq(J.T, law.handover, rcond=None)[0]
            errors.append(rest / np.abs(u).max())
    return Measured(worst(errors), "against u, in least squares along the hands")


def _runs(
    evidence: Evidence, projector: Projector
) -> Iterator[tuple[PassivityController, ContactStack, Array, Array, Array]]:
    """Yield laws that run, with the contacts that hold next, their multipliers, and a state."""
    robot, generator = evidence.robot, evidence.generator()
    every = evidence.contacts
    left, right, grasp = every.contacts
    for first, then in (
        ([left, right], [left]), ([left], [left, right]), ([left, right, grasp], [right, grasp]),
        ([right, grasp], [left, right, grasp]),
    ):  # fmt: skip
        law = _law(evidence, every, inertia(robot, robot.q_half_sitting), projector)
        law.gains = ControlGains(**{**vars(law.gains), "damp_violation": True})
        before, after = ContactStack(first), ContactStack(then)
        law.switch(before)
        wanted = np.full(before.regulated_rows.size, 20.0)
        for tick in range(3):
            q = pin.integrate(
                robot.model, robot.q_half_sitting, 1e-3 * generator.normal(size=robot.nv)
            )
            v = 0.01 * generator.normal(size=robot.nv)
            lam = generator.normal(size=before.size)
            reference = Reference(robot.q_half_sitting, np.zeros(robot.nv), wanted)
            law.step(tick * DT, Measurement(q, v, lam), reference)
        yield law, after, generator.normal(size=after.size), q, v


def _energies(loss: Loss) -> tuple[float, float]:
    """Return V~ of the first tick by the physics, and as lam_R^T W lam_R / (2 kappa^2) has it.

    With K_d = kappa H the robot sets off as H a = -K_d s~ on the contact that is left.
    """
    Z = null_space(loss.J[:6])
    JZ = loss.J[6:] @ Z
    W = JZ @ np.linalg.solve(Z.T @ loss.H @ Z, JZ.T)
    lam = loss.lam[6:]
    measured = 0.5 * float(loss.a @ loss.H @ loss.a) / KAPPA**2
    return measured, 0.5 * float(lam @ W @ lam) / KAPPA**2


def _energy_of_torque(evidence: Evidence) -> Measured:
    """Lift-off, torque kept: V~ rises by lam_R^T W lam_R / (2 kappa^2)."""
    errors, notes = [], []
    for projector in PROJECTORS:
        loss = _lose(evidence, "torque", projector)
        measured, predicted = _energies(loss)
        errors.append(measured / predicted - 1.0)
        notes.append(
            f"{loss.lam[8]:.0f} N lost: {measured:.4g} J, predicted {predicted:.4g} J, torque jump "
            f"{np.abs(loss.tau - loss.before).max():.1g} N m"
        )
    return Measured(worst(errors), notes[0])


def _energy_kept(evidence: Evidence) -> Measured:
    """Lift-off, energy kept: V~ stays; what it costs is a jump of the torque."""
    shares, notes = [], []
    for projector in PROJECTORS:
        loss = _lose(evidence, "energy", projector)
        measured, predicted = _energies(loss)
        shares.append(measured / predicted)
        notes.append(
            f"{measured:.1g} J instead of {predicted:.2g}, torque jump "
            f"{np.abs(loss.tau - loss.before).max():.0f} N m"
        )
    return Measured(max(shares), notes[0])


def _touchdown(evidence: Evidence) -> Measured:
    """The map at touchdown as a matrix, column by column from the law: V+ against V-, the worst."""
    robot = evidence.robot
    dq = np.zeros(robot.nv)
    for side, turn in (("L", -STEP), ("R", STEP)):
        for joint, share in (("2", 1.0), ("4", -1.0)):
            index = robot.joint_index(f"{side}LEG_JOINT{joint}")
            dq[robot.nv_base + index] = turn * share
    q = pin.integrate(robot.model, robot.q_half_sitting, dq)
    kin = robot.at(q)
    soles = [SoleContact.standing(sole, kin) for sole in robot.soles]
    one, both = ContactStack(soles[:1]), ContactStack(soles)
    ratios, H = [], inertia(robot, q)
    Z = null_space(one.jacobian(kin))
    for projector in PROJECTORS:
        law = _law(evidence, both, inertia(robot, robot.q_half_sitting), projector)
        P = np.column_stack([_mapped(law, one, both, q, column) for column in Z.T])
        ratios.append(eigenvalues(P.T @ H @ P, Z.T @ H @ Z)[-1])
    Q = np.eye(robot.nv) - np.linalg.pinv(both.jacobian(kin)) @ both.jacobian(kin)
    printed = eigenvalues((Q @ Z).T @ H @ (Q @ Z), Z.T @ H @ Z)[-1]
    note = f"K_d = kappa H of half-sitting, a step of 0.2 m; by Q_phi it would be {printed:.0f}"
    return Measured(float(max(ratios)), note)


def _mapped(
    law: PassivityController, one: ContactStack, both: ContactStack, q: Array, s: Array
) -> Array:
    """Return the s+ (nv,) that a law makes at touchdown of an integral that commands `s` (nv,)."""
    still = np.zeros(len(s))
    reference = Reference(q, still, np.zeros(0))
    law.reset()
    law.hold(one)
    law.step(0.0, Measurement(q, still, np.zeros(6)), reference)
    law.posture.integral_of_sign[:] = SMALL * s / law.gains.k_ip  # no torque is clamped
    law.step(0.0, Measurement(q, still, np.zeros(6)), reference)
    law.switch(both)
    return law.step(0.0, Measurement(q, still, np.zeros(12)), reference).s / SMALL


CHECKS = (
    Check("S torque", "supports come or go: the torque is continuous",
          "control.PassivityController.switch", 1e-8, "", _continuous),
    Check("S absorbed", "integral and F+ take what the torque carried, but along hands",
          "control.PassivityController.switch", 1e-8, "", _absorbed),
    Check("S energy", "torque kept: V rises by lam^T W lam / (2 kappa^2)",
          "control.PassivityController.switch", 1e-2, "", _energy_of_torque),
    Check("S load", "energy kept: V does not rise", "control.PassivityController.switch", 1e-2, "",
          _energy_kept),
    Check("S touchdown", "V+ / V- at touchdown, the worst s", "control.PassivityController.switch",
          1.1, "", _touchdown),
)  # fmt: skip
