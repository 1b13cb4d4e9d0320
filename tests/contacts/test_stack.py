"""The stacked contacts: projector and pseudo-inverse, with and without redundancy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack, GraspContact, SoleContact
from equipoise.errors import NameNotFoundError
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


def test_a_sole_stands_where_it_is(hrp2, rng):
    """A joint of its leg that moves takes it away, one of an arm does not."""
    q, _ = random_state(hrp2, rng)
    kin, sole = kinematics(hrp2, q), hrp2.soles[0]
    contact = SoleContact.standing(sole, kin)
    assert (contact.name, contact.supporting) == (sole.name, True)
    assert contact.friction == SoleContact.friction
    assert np.abs(contact.residual(kin)).max() < 1e-15
    for joint, moves in (("LLEG_JOINT5", True), ("LARM_JOINT3", False)):
        dq = np.zeros(hrp2.nv)
        dq[6 + hrp2.joint_index(joint)] = 0.1
        there = kinematics(hrp2, pin.integrate(hrp2.model, q, dq))
        assert (np.abs(contact.residual(there)).max() > 1e-3) == moves
    other = SoleContact.standing(sole, kin, name="floor", supporting=False, friction=0.2)
    assert (other.name, other.supporting, other.friction) == ("floor", False, 0.2)
    with pytest.raises(NameNotFoundError, match="left_sole"):
        SoleContact.standing(replace(sole, frame="left_soul"), kin)


def test_a_grasp_holds_wherever_the_robot_is_carried(hrp2, rng):
    q, _ = random_state(hrp2, rng)
    palms = [palm.frame for palm in hrp2.palms]
    grasp = GraspContact.holding("grasp", kinematics(hrp2, q), *palms, regulated=("fz",))
    for i in range(hrp2.nv):
        dq = np.zeros(hrp2.nv)
        dq[i] = 0.1
        there = kinematics(hrp2, pin.integrate(hrp2.model, q, dq))
        name = hrp2.velocity_names[i]
        apart = name.startswith(("LARM", "RARM")) and not name.endswith("6")  # 6: the fingers
        assert (np.abs(grasp.residual(there)).max() > 1e-6) == apart, name
    with pytest.raises(NameNotFoundError, match="left_palm"):
        GraspContact.holding("grasp", kinematics(hrp2, q), "left_plam", palms[1])


def test_no_contact_at_all(hrp2, rng):
    q, v = random_state(hrp2, rng)
    stacked = ContactStack([]).at(kinematics(hrp2, q))
    assert stacked.rank == 0
    assert np.array_equal(stacked.project(v), v)
    assert np.array_equal(stacked.lift(np.zeros(0)), np.zeros(hrp2.nv))
