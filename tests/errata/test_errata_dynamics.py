"""Errata of the dynamics: each printed form fails its test, each repaired form passes."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.physics import RigidContactEngine
from equipoise.spatial.coordinates import base_rate_map, rotation_coordinates
from equipoise.verify.error_dynamics import (
    Dynamics,
    dynamic_parameters,
    inertia,
    reference_regressor,
    regressor,
)
from helpers import full_stack, kinematics, random_state, sole_contacts

STEP = 1e-6


def test_4_the_transposed_contact_jacobian_is_n_by_6r(hrp2):
    """(4) says J_c^T is 6r x n; only n x 6r maps wrenches to generalised forces."""
    q = hrp2.q_half_sitting
    J_c = ContactStack(sole_contacts(hrp2, q)).jacobian(kinematics(hrp2, q))
    wrenches = np.ones(12)
    assert (J_c.T @ wrenches).shape == (hrp2.nv,)
    assert J_c.T.shape == (hrp2.nv, 12)
    with pytest.raises(ValueError, match="mismatch"):
        J_c @ wrenches


@pytest.mark.parametrize("printed", [True, False])
def test_6_torque_acts_through_the_selection_only(hrp2, rng, printed):
    """(6), (8) write tau, where (1) has S^T tau: an unlimited motor would hold the base in the air.

    Without contacts the momentum of the robot changes by gravity alone, whatever the joints do.
    """
    q, v = random_state(hrp2, rng)
    tau = rng.normal(size=hrp2.nv) * 20
    force = tau if printed else np.concatenate((np.zeros(6), tau[6:]))
    a, _ = RigidContactEngine(hrp2, ContactStack([]), q, 1e-3, v_start=v).accelerations(force)
    data = hrp2.model.createData()
    pin.computeCentroidalMomentumTimeVariation(hrp2.model, data, q, v, a)
    rate = data.dhg.vector
    expected = np.array([0.0, 0.0, -9.81 * hrp2.mass, 0.0, 0.0, 0.0])
    assert np.allclose(rate, expected, atol=1e-6) is not printed


@pytest.mark.parametrize("printed", [True, False])
def test_8_the_second_row_has_the_derivative_of_the_jacobian(hrp2, rng, printed):
    """(8) prints `J_c qdot - nudot_c`: with it, moving contacts would leave (7) at once."""
    q, v = random_state(hrp2, rng)
    stack = full_stack(hrp2, q)
    kin = kinematics(hrp2, q, v)
    J, drift = stack.jacobian(kin), stack.drift(kin)
    right = -(J @ v) if printed else -drift  # nudot_c = 0
    a = np.linalg.pinv(J) @ right
    step = 1e-5
    speeds = [
        stack.jacobian(kinematics(hrp2, pin.integrate(hrp2.model, q, s * step * v)))
        @ (v + s * step * a)
        for s in (1, -1)
    ]
    rate = (speeds[0] - speeds[1]) / (2 * step)
    assert np.allclose(rate, 0.0, atol=1e-5) is not printed


@pytest.mark.parametrize("printed", [True, False])
def test_skew_symmetry_is_of_the_rate_less_twice_coriolis(hrp2, rng, printed):
    """The print has `xi^T (Hdot - C) xi = 0`, "for all xi"."""
    q, v = random_state(hrp2, rng)
    ahead, behind = (inertia(hrp2, pin.integrate(hrp2.model, q, s * STEP * v)) for s in (1, -1))
    rate = (ahead - behind) / (2 * STEP)
    xi = rng.normal(size=hrp2.nv)
    C = Dynamics.at(hrp2, q, v).C
    power = xi @ (rate - (1.0 if printed else 2.0) * C) @ xi
    assert (abs(power) < 1e-6) is not printed


@pytest.mark.parametrize("printed", [True, False])
def test_polarised_coriolis_terms_are_not_skew_with_a_base_twist(hrp2, rng, printed):
    """The usual C (Christoffel symbols) needs coordinates; a base twist needs its bracket."""
    q, v = random_state(hrp2, rng)
    ahead, behind = (inertia(hrp2, pin.integrate(hrp2.model, q, s * STEP * v)) for s in (1, -1))
    rate, theta, still = (ahead - behind) / (2 * STEP), dynamic_parameters(hrp2), np.zeros(hrp2.nv)
    xi = rng.normal(size=hrp2.nv)
    bracket = still.copy()
    bracket[:6] = pin.Motion(v[:6]).cross(pin.Motion(xi[:6])).vector
    C_xi = (reference_regressor(hrp2, q, v, xi, still) - regressor(hrp2, q, still, still)) @ theta
    if printed:
        C_xi = C_xi - 0.5 * inertia(hrp2, q) @ bracket
    assert (abs(xi @ (rate @ xi - 2.0 * C_xi)) < 1e-6) is not printed


def test_17_has_no_inverse_where_there_are_more_parameters_than_three(rng):
    """`J_x^-T` exists for l = 3 only; the pseudo-inverse of J_x^T is what keeps the power."""
    R = pin.exp3(rng.normal(size=3))
    for name in ("unit quaternion", "matrix entries"):
        coordinates = rotation_coordinates(name)
        J_x = base_rate_map(coordinates, coordinates.parameters(R))
        assert J_x.shape[0] != J_x.shape[1]
        with pytest.raises(np.linalg.LinAlgError):
            np.linalg.inv(J_x.T)
