"""One constant K_d for every posture of the arms: sampled damping stays stable, with M(q_0) not."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

from equipoise import get_robot
from equipoise.contacts import ContactStack
from equipoise.control import advise_for_postures, advise_gains, bear_postures
from equipoise.control.passivity.gain_advice import inertia_matrix, random_postures
from equipoise.errors import InputError
from helpers import sole_contacts

DT = 0.001


def fastest_mode(robot, contacts, K_d, q):
    """Return the spectral radius of `v <- v - dt M^-1 K_d v` on the tangent space at `q`."""
    Z = scipy.linalg.null_space(contacts.at(robot.at(q)).J_phi)
    M = Z.T @ inertia_matrix(robot, q) @ Z
    step = np.eye(Z.shape[1]) - DT * np.linalg.solve(M, Z.T @ K_d @ Z)
    return float(np.abs(np.linalg.eigvals(step)).max())


@pytest.mark.parametrize("name", ["hrp2", "talos", "g1", "romeo"])
def test_sampled_damping_is_stable_at_postures_that_were_not_looked_at(name):
    try:
        robot = get_robot(name)
    except InputError as error:
        pytest.skip(str(error))
    q_0 = robot.q_half_sitting
    contacts = ContactStack(sole_contacts(robot, q_0))
    everywhere = advise_for_postures(robot, contacts, q_0, DT, alpha=20.0)
    at_start = advise_gains(robot, contacts, q_0, DT, alpha=20.0)
    seen = random_postures(robot, q_0, 40, seed=99)
    assert max(fastest_mode(robot, contacts, everywhere.K_d, q) for q in seen) < 1.0
    assert max(fastest_mode(robot, contacts, at_start.K_d, q) for q in seen) > 1.5
    assert np.linalg.eigvalsh(everywhere.K_d)[0] > 0.0
    assert everywhere.kappa == pytest.approx(0.5 * everywhere.kappa_max_rigid)
    assert "mean of M over postures" in everywhere.sentences()[0]


def test_the_same_robot_gets_the_same_gains(hrp2):
    q_0 = hrp2.q_half_sitting
    contacts = ContactStack(sole_contacts(hrp2, q_0))
    first, second = (advise_for_postures(hrp2, contacts, q_0, DT, alpha=20.0) for _ in range(2))
    np.testing.assert_array_equal(first.K_d, second.K_d)
    given = advise_for_postures(hrp2, contacts, q_0, DT, alpha=20.0, kappa=first.kappa / 2.0)
    np.testing.assert_allclose(given.K_d, first.K_d / 2.0)


@pytest.mark.parametrize("wrong", [{"alpha": -1.0}, {"kappa": 0.0}, {"rotor_inertia": np.nan}])
def test_numbers_of_the_wrong_sign_are_refused(hrp2, wrong):
    contacts = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    with pytest.raises(InputError):
        advise_for_postures(hrp2, contacts, hrp2.q_half_sitting, DT, **{"alpha": 20.0, **wrong})


def test_damping_is_taken_where_a_posture_cannot_bear_it_and_nowhere_else():
    """Less than before in every direction, stable in each posture, and untouched elsewhere."""
    robot = get_robot("hrp2")
    contacts, q_0 = ContactStack(sole_contacts(robot, robot.q_half_sitting)), robot.q_half_sitting
    before = advise_gains(robot, contacts, q_0, DT, alpha=20.0)
    postures = random_postures(robot, q_0, 10, seed=3)
    assert max(fastest_mode(robot, contacts, before.K_d, q) for q in postures) > 1.0
    after = bear_postures(before, robot, contacts, postures, DT)
    assert max(fastest_mode(robot, contacts, after.K_d, q) for q in postures) < 1.0
    taken = np.linalg.eigvalsh(before.K_d - after.K_d)
    assert taken.min() > -1e-9 * taken.max()
    assert (taken > 1e-9 * taken.max()).sum() < robot.nv
    assert np.linalg.eigvalsh(after.K_d).min() > 0.0
    assert "less where" in after.sentences()[0]


def test_what_is_borne_is_left_as_it_is():
    robot = get_robot("hrp2")
    contacts, q_0 = ContactStack(sole_contacts(robot, robot.q_half_sitting)), robot.q_half_sitting
    before = advise_gains(robot, contacts, q_0, DT, alpha=20.0)
    assert bear_postures(before, robot, contacts, [q_0], DT) is before
