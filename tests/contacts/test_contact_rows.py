"""Rows, residuals and drifts of every contact kind against finite differences."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.errors import InputError, NameNotFoundError
from helpers import full_stack, kinematics, palm_grasp, random_state, sole_contacts

STEP = 1e-6


@pytest.mark.parametrize("index", [0, 1, 2])
def test_rows_are_the_rate_of_the_residual(hrp2, rng, index):
    q, v = random_state(hrp2, rng)
    contact = full_stack(hrp2, q).contacts[index]
    ahead = contact.residual(kinematics(hrp2, pin.integrate(hrp2.model, q, v * STEP)))
    behind = contact.residual(kinematics(hrp2, pin.integrate(hrp2.model, q, -v * STEP)))
    rate = (ahead - behind) / (2 * STEP)
    assert np.allclose(contact.jacobian(kinematics(hrp2, q)) @ v, rate, atol=1e-7)


@pytest.mark.parametrize("index", [0, 1, 2])
def test_drift_is_the_rate_of_the_rows(hrp2, rng, index):
    q, v = random_state(hrp2, rng)
    contact = full_stack(hrp2, q).contacts[index]
    ahead = contact.jacobian(kinematics(hrp2, pin.integrate(hrp2.model, q, v * STEP))) @ v
    behind = contact.jacobian(kinematics(hrp2, pin.integrate(hrp2.model, q, -v * STEP))) @ v
    rate = (ahead - behind) / (2 * STEP)
    assert np.allclose(contact.drift(kinematics(hrp2, q, v)), rate, atol=1e-6)


def test_a_grasp_wrench_is_internal(hrp2, rng):
    """The object has no mass: what it does to one hand it undoes at the other; the base is free."""
    q, _ = random_state(hrp2, rng)
    J = palm_grasp(hrp2, q).jacobian(kinematics(hrp2, q))
    assert np.abs(J[:, :6]).max() < 1e-12
    assert np.linalg.matrix_rank(J) == 6


def test_positive_normal_force_squeezes(hrp2):
    """lam_z > 0 pushes the right palm away from the left one, along the left palm's normal."""
    q = hrp2.q_half_sitting
    kin = kinematics(hrp2, q)
    left, right = (hrp2.frame_id(palm.frame) for palm in hrp2.palms)
    across = kin.placement(right).translation - kin.placement(left).translation
    assert across @ kin.placement(left).rotation[:, 2] > 0.0
    force = palm_grasp(hrp2, q).jacobian(kin)[2]
    apart = kin.jacobian(right)[:3] - kin.jacobian(left)[:3]
    assert force @ (apart.T @ across) > 0.0


def test_unknown_regulated_row_is_refused(hrp2):
    with pytest.raises(NameNotFoundError, match="fq"):
        palm_grasp(hrp2, hrp2.q_half_sitting, regulated=("fq",))


def test_two_contacts_of_one_name_are_refused(hrp2):
    sole = sole_contacts(hrp2, hrp2.q_half_sitting)[0]
    with pytest.raises(InputError, match="share a name"):
        ContactStack([sole, sole])
