"""The stacked contacts: projector and pseudo-inverse, with and without redundancy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from equipoise.contacts import ContactStack
from helpers import full_stack, kinematics, palm_grasp, random_state, sole_contacts


@pytest.fixture(params=["full rank", "a sole twice"])
def stacked(request, hrp2, rng):
    q, _ = random_state(hrp2, rng)
    stack = full_stack(hrp2, q)
    if request.param == "a sole twice":
        stack = ContactStack([*stack.contacts, replace(stack.contacts[0], name="again")])
    return stack.at(kinematics(hrp2, q))


def test_projector_theorems(stacked):
    Q, J = stacked.Q_phi, stacked.J_phi
    assert np.allclose(Q @ Q, Q, atol=1e-12)
    assert np.allclose(Q, Q.T, atol=1e-15)
    assert np.abs(J @ Q).max() < 1e-12
    assert stacked.rank == np.linalg.matrix_rank(J) == 18
    assert np.isclose(np.trace(Q), J.shape[1] - stacked.rank)


def test_pseudo_inverse_is_that_of_numpy(stacked, rng):
    expected = np.linalg.pinv(stacked.J_phi)
    assert np.allclose(stacked.J_phi_pinv, expected, atol=1e-9 * np.abs(expected).max())
    v = rng.normal(size=stacked.J_phi.shape[1])
    assert np.allclose(stacked.project(v) + stacked.lift(stacked.J_phi @ v), v, atol=1e-10)


def test_rows_of_each_contact(hrp2, rng):
    q, _ = random_state(hrp2, rng)
    stack = ContactStack([*sole_contacts(hrp2, q), palm_grasp(hrp2, q, ("fz", "mx"))])
    assert stack.size == 18
    assert list(stack.regulated_rows) == [14, 15]
    assert list(stack.supporting_rows) == list(range(12))
    parts = stack.split(np.arange(18.0))
    assert list(parts) == ["left_sole", "right_sole", "grasp"]
    assert parts["grasp"][0] == 12.0


def test_no_contact_at_all(hrp2, rng):
    q, v = random_state(hrp2, rng)
    stacked = ContactStack([]).at(kinematics(hrp2, q))
    assert stacked.rank == 0
    assert np.array_equal(stacked.project(v), v)
    assert np.array_equal(stacked.lift(np.zeros(0)), np.zeros(hrp2.nv))
