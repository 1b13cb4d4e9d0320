"""Checks a built model: finite, massive, with an inertia matrix that can be inverted."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.robots.base import actuated_joints, base_of
from equipoise.robots.dynamics import JointDynamics
from equipoise.robots.files.finding import ERROR, Finding
from equipoise.robots.files.values import LIMIT_SLACK

# Smallest eigenvalue of the inertia matrix scaled to a unit diagonal; below it the matrix is
# singular to double precision (about 50 coordinates times 2e-16, with a margin).
SMALLEST_EIGENVALUE = 1e-12


def check_model(model: pin.Model, q_half_sitting: np.ndarray) -> list[Finding]:
    """Return what is wrong with a built model and its half-sitting posture."""
    findings = [*_check_limits(model), *_check_posture(model, q_half_sitting)]
    mass = sum(inertia.mass for inertia in model.inertias[1:])
    if not (np.isfinite(mass) and mass > 0.0):
        findings.append(Finding(ERROR, "robot", "the total mass must be positive", given=f"{mass}"))
    for name, q in (("zero", pin.neutral(model)), ("half-sitting", q_half_sitting)):
        problem = inertia_problem(model, q)
        if problem:
            findings.append(
                Finding(
                    ERROR,
                    f"robot in the {name} posture",
                    problem,
                    remedy="Look for links with far too small or too large mass or inertia",
                )
            )
    return findings


def inertia_problem(model: pin.Model, q: np.ndarray) -> str:
    """Return what is wrong with the inertia matrix at q (nq,), or nothing."""
    matrix = JointDynamics(model).inertia(q)
    diagonal = np.diag(matrix)
    if not np.isfinite(matrix).all():
        return "the inertia matrix is not finite"
    if not (diagonal > 0.0).all():
        return "the inertia matrix has a diagonal entry that is not positive"
    scale = np.sqrt(diagonal)
    smallest = float(np.linalg.eigvalsh(matrix / scale / scale[:, None])[0])
    if not smallest > SMALLEST_EIGENVALUE:
        return f"the inertia matrix is not positive definite (smallest eigenvalue {smallest:.1e})"
    return ""


def _names(model: pin.Model) -> list[str]:
    return [model.names[joint] for joint in actuated_joints(model)]


def _check_limits(model: pin.Model) -> list[Finding]:
    """Check that Pinocchio holds finite limits of the right sign for every actuated joint."""
    base = base_of(model)
    rows = {
        "position": model.upperPositionLimit[base.nq :] - model.lowerPositionLimit[base.nq :],
        "velocity": model.upperVelocityLimit[base.nv :],
        "effort": model.upperEffortLimit[base.nv :],
    }
    return [
        Finding(ERROR, f"joint {name!r}", f"its {kind} limits are not usable", given=f"{value}")
        for kind, values in rows.items()
        for name, value in zip(_names(model), values, strict=True)
        if not (np.isfinite(value) and value > 0.0)
    ]


def _check_posture(model: pin.Model, q: np.ndarray) -> list[Finding]:
    """Check that the half-sitting posture is finite and inside the joint limits."""
    findings = []
    low, high = model.lowerPositionLimit, model.upperPositionLimit
    base = base_of(model)
    for index, name in enumerate(_names(model), start=base.nq):
        if not low[index] - LIMIT_SLACK <= q[index] <= high[index] + LIMIT_SLACK:
            findings.append(
                Finding(
                    ERROR,
                    f"joint {name!r}",
                    f"half-sitting lies outside its limits {low[index]:g} .. {high[index]:g}",
                    remedy="Correct the posture or the limits",
                    given=f"{q[index]:g}",
                )
            )
    if not np.isfinite(q).all():
        findings.append(Finding(ERROR, "half-sitting", "the posture is not finite"))
    return findings
