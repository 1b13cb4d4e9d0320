"""Rows of the geometry: coordinates (2)-(3), (17) and contacts (4)-(5), (7), (12)-(13)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from equipoise.contacts import ContactStack, PointContact, SoleContact
from equipoise.kinematics import Kinematics
from equipoise.physics import RigidContactEngine, RigidOptions
from equipoise.spatial import Array
from equipoise.spatial.coordinates import (
    ROTATION_COORDINATES,
    base_rate_map,
    contact_wrench,
    wrench_gradient,
)
from equipoise.verify.contact_wrenches import wrenches_of
from equipoise.verify.evidence import SURFACES, Evidence
from equipoise.verify.row import Check, Measured, worst

STEP = 1e-6  # of central differences


def _rates(evidence: Evidence) -> Measured:
    """(2), (3): twist from differentiated coordinates against the twist that moved the base."""
    generator, errors = evidence.generator(), []
    for coordinates in ROTATION_COORDINATES.values():
        for _ in range(5):
            R, twist = pin.exp3(generator.normal(size=3)), generator.normal(size=6)
            theta = coordinates.parameters(R)
            ends = [coordinates.parameters(pin.exp3(s * STEP * twist[3:]) @ R) for s in (1, -1)]
            if coordinates.name == "unit quaternion" and ends[0] @ ends[1] < 0.0:
                ends[1] = -ends[1]
            rates = np.concatenate((twist[:3], (ends[0] - ends[1]) / (2 * STEP)))
            errors.append(base_rate_map(coordinates, theta) @ rates - twist)
    return Measured(worst(errors), "four parametrisations, random rotations and twists")


def _slopes(evidence: Evidence) -> Measured:
    """(3): J_theta against the map of a rotation's own derivative, `[omega x] = dR/dt R^T`."""
    generator, errors = evidence.generator(), []
    for coordinates in ROTATION_COORDINATES.values():
        theta = coordinates.parameters(pin.exp3(generator.normal(size=3)))
        R, J_theta = coordinates.rotation(theta), coordinates.rate_map(theta)
        tangent = np.linalg.pinv(J_theta)
        for e in np.eye(3):
            rate = tangent @ e
            change = coordinates.rotation(theta + STEP * rate) - coordinates.rotation(
                theta - STEP * rate
            )
            errors.append(pin.unSkew(change / (2 * STEP) @ R.T) - e)
    return Measured(worst(errors), "J_theta J_theta^+ e turns the rotation about e")


def _generalised_force(evidence: Evidence) -> Measured:
    """(4): J^T lam against Pinocchio's inverse dynamics under the same wrenches on the bodies."""
    generator, errors = evidence.generator(), []
    robot, still = evidence.robot, np.zeros(evidence.robot.nv)
    q = evidence.states[0][0]
    kin = evidence.at(q, still)
    for contact in evidence.contact_kinds(q):
        lam = generator.normal(size=contact.size)
        forces = pin.StdVec_Force([pin.Force.Zero() for _ in range(robot.model.njoints)])
        for wrench in wrenches_of(contact, kin, lam):
            joint = robot.model.frames[robot.frame_id(wrench.frame)].parentJoint
            T_world_joint = kin.pin_data.oMi[joint]
            at_origin = wrench.moment + np.cross(wrench.p_world, wrench.force)
            forces[joint] += T_world_joint.actInv(pin.Force(wrench.force, at_origin))
        data = robot.model.createData()
        without = pin.rnea(robot.model, data, q, still, still).copy()
        with_them = pin.rnea(robot.model, data, q, still, still, forces)
        errors.append(contact.jacobian(kin).T @ lam - (without - with_them))
    return Measured(worst(errors), "every kind of contact, random multipliers")


def _contact_velocity(evidence: Evidence) -> Measured:
    """(5): J v - nu_c against the differentiated residual."""
    errors = []
    for q, v in evidence.states:
        for contact in evidence.contact_kinds(q):
            ends = [contact.residual(_flowed(evidence, q, v, s * STEP)) for s in (1, -1)]
            kin = evidence.at(q, v)
            speed = contact.jacobian(kin) @ v - contact.rate(kin)
            errors.append(speed - (ends[0] - ends[1]) / (2 * STEP))
    return Measured(worst(errors), "soles, grasp, point, five surfaces at rest and moving")


def _contact_acceleration(evidence: Evidence) -> Measured:
    """(8), second row: the drift against the differentiated J v - nu_c."""
    errors = []
    for q, v in evidence.states:
        for contact in evidence.contact_kinds(q):
            kins = [_flowed(evidence, q, v, s * STEP) for s in (1, -1)]
            ends = [contact.jacobian(kin) @ v - contact.rate(kin) for kin in kins]
            errors.append(contact.drift(evidence.at(q, v)) - (ends[0] - ends[1]) / (2 * STEP))
    return Measured(worst(errors), "curvature, normalisation and motion of the surface included")


def _simulated_acceleration(evidence: Evidence) -> Measured:
    """(8), second row as simulated: with a, J v - nu_c stays what it is (no stabilisation)."""
    errors, robot = [], evidence.robot
    for q, v in evidence.states:
        for contact in evidence.contact_kinds(q)[3:]:
            stack = ContactStack([*evidence.contact_kinds(q)[:3], contact])
            engine = RigidContactEngine(
                robot,
                stack,
                q,
                1e-3,
                options=RigidOptions(position_gain=0.0, velocity_gain=0.0),
                v_start=v,
            )
            a, _ = engine.accelerations(np.zeros(robot.nv))
            speeds = []
            for s in (1, -1):
                kin = _flowed(evidence, q, v, s * STEP)
                speeds.append(stack.jacobian(kin) @ (v + s * STEP * a) - stack.rate(kin))
            errors.append((speeds[0] - speeds[1]) / (2 * STEP) / np.abs(a).max())
    return Measured(worst(errors), "soles and grasp with one contact of every other kind")


def _flowed(evidence: Evidence, q: Array, v: Array, span: float) -> Kinematics:
    return evidence.at(pin.integrate(evidence.robot.model, q, v * span), v, span)


def _surfaces(evidence: Evidence) -> Measured:
    """(13): gradient and Hessian of every surface against finite differences of phi."""
    generator, errors = evidence.generator(), []
    for surface in SURFACES:
        for x in generator.uniform(0.1, 0.4, (5, 3)):
            for i, e in enumerate(np.eye(3)):
                a, b = x + STEP * e, x - STEP * e
                slope = (surface.value(a) - surface.value(b)) / (2 * STEP)
                bend = (surface.gradient(a) - surface.gradient(b)) / (2 * STEP)
                scale = 1.0 + float(np.abs(surface.hessian(x)).max())
                errors.append((surface.gradient(x)[i] - slope) / scale)
                errors.append((surface.hessian(x)[i] - bend) / scale)
    return Measured(worst(errors), ", ".join(surface.name for surface in SURFACES))


def _kept_contacts(evidence: Evidence) -> Measured:
    """(7), (13): how far the contacts of the run are from zero."""
    run = evidence.moving_run(1e-3)
    errors = [run.contacts.residual(run.kinematics(sample)) for sample in run.samples[::5]]
    return Measured(worst(errors), "largest |phi| along the run, feet and grasp")


def _projector(evidence: Evidence) -> Measured:
    """(12) for J_phi: J Q = 0, Q Q = Q = Q^T, rank Q = n - r, and J J^+ = I."""
    run = evidence.moving_run(1e-3)
    errors: list[ArrayLike] = []
    for index in evidence.spread_samples(1e-3, 10):
        stacked = run.contacts.at(run.kinematics(run.samples[index]))
        Q, J = stacked.Q_phi, stacked.J_phi
        rank = np.linalg.matrix_rank(J)
        errors += [J @ Q, Q @ Q - Q, Q - Q.T, J @ stacked.J_phi_pinv - np.eye(len(J))]
        errors += [np.linalg.matrix_rank(Q) - (J.shape[1] - rank), stacked.rank - rank]
        errors.append(J.T @ np.linalg.pinv(J.T) - stacked.J_phi_pinv @ J)
        errors.append(np.column_stack([stacked.project(e) for e in np.eye(len(Q))]) - Q)
    return Measured(worst(errors), "18 rows, 36 velocities, along the run")


def _redundant_contacts(evidence: Evidence) -> Measured:
    """Four corner points a foot give the net wrench of the six-row sole."""
    robot, q = evidence.robot, evidence.robot.q_half_sitting
    soles = [c for c in evidence.soles.contacts if isinstance(c, SoleContact)]
    corners = [
        PointContact(
            name=f"{sole.name}/{i}",
            frame=sole.sole.frame,
            offset=tuple(corner),
            p_world=sole.T_world_anchor.act(corner),
        )
        for sole in soles
        for i, corner in enumerate(sole.sole.corners)
    ]
    tau = evidence.generator().normal(size=robot.na) * 10.0
    force = np.concatenate((np.zeros(robot.nv_base), tau))
    _, lam = RigidContactEngine(robot, evidence.soles, q, 1e-3).accelerations(force)
    _, parts = RigidContactEngine(robot, ContactStack(corners), q, 1e-3).accelerations(force)
    net = []
    for k, sole in enumerate(soles):
        forces = parts[12 * k : 12 * k + 12].reshape(4, 3) @ sole.T_world_anchor.rotation
        net += [forces.sum(axis=0), np.cross(sole.sole.corners, forces).sum(axis=0)]
    scale = np.abs(lam).max()
    error = worst([np.concatenate(net) - lam]) / scale
    share = np.abs(parts).max() / scale
    return Measured(
        error if share < 10.0 else np.inf,
        f"24 rows of rank 12; largest multiplier {share:.2f} times that of the soles",
    )


def _wrench_in_coordinates(evidence: Evidence) -> Measured:
    """(17): one constraint, one lam, four coordinates: one wrench and one power."""
    generator = evidence.generator()
    errors: list[ArrayLike] = []
    for coordinates in ROTATION_COORDINATES.values():
        for _ in range(5):
            R = pin.exp3(generator.normal(size=3))
            theta = coordinates.parameters(R)
            rows, lam = generator.normal(size=(2, 6)), generator.normal(size=2)
            gradient = wrench_gradient(coordinates, theta, rows)
            wrench = contact_wrench(coordinates, theta, gradient, lam)
            twist = generator.normal(size=6)
            rates = np.linalg.pinv(base_rate_map(coordinates, theta)) @ twist
            errors += [wrench - rows.T @ lam, [lam @ gradient @ rates - twist @ wrench]]
    return Measured(worst(errors), "power lam . dphi/dt is that of the wrench in all of them")


CHECKS = (
    Check("(2)", "J_x maps rates of base coordinates to the twist",
          "spatial.coordinates.base_rate_map", 1e-7, "m/s, rad/s", _rates),
    Check("(3)", "J_theta from the columns of R, four parametrisations",
          "spatial.coordinates.RotationCoordinates.rate_map", 1e-7, "rad/s", _slopes),
    Check("(4)", "J_c^T F_c is the generalised force of the contact wrenches",
          "contacts.*.jacobian", 1e-9, "N, N m", _generalised_force),
    Check("(5)", "J_c v is the contact velocity", "contacts.*.jacobian, .rate", 1e-6,
          "m/s, rad/s", _contact_velocity),
    Check("(7)", "the contacts of a run stay where they are", "physics.RigidContactEngine", 1e-5,
          "m, rad", _kept_contacts),
    Check("(8) row 2", "J a + drift is the second derivative of the contact",
          "contacts.*.drift", 1e-5, "m/s2, rad/s2", _contact_acceleration),
    Check("(8)", "simulated accelerations keep J v = nu_c", "physics.RigidContactEngine", 1e-6, "",
          _simulated_acceleration),
    Check("(12)", "J_phi Q_phi = 0, Q_phi symmetric, idempotent, of rank n - r; J_phi J_phi^+ = I",
          "contacts.StackedContacts", 1e-9, "", _projector),
    Check("(13)", "gradient and Hessian of the surfaces", "contacts.surfaces", 1e-7, "",
          _surfaces),
    Check("(17)", "wrench and power are the same in all coordinates",
          "spatial.coordinates.contact_wrench", 1e-9, "N, N m, W", _wrench_in_coordinates),
    Check("redundancy", "four corner points a foot carry the wrench of the sole",
          "physics.RigidContactEngine", 1e-6, "", _redundant_contacts),
)  # fmt: skip
