"""The load split: shares from the ZMP, and what was there at a switch fades without a jump."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.contacts import ContactStack, PointContact
from equipoise.control import (
    ControlGains,
    Measurement,
    PassivityController,
    ReactionBounds,
    Reference,
)
from equipoise.errors import InputError
from helpers import kinematics, sole_contacts

DT = 1e-3


def law_on(robot, contacts, *, bounds=None, **gains):
    return PassivityController(
        robot, ContactStack(contacts), ControlGains(K_d=10.0, **gains), DT, bounds=bounds,
        split="zmp",
    )  # fmt: skip


def carried_at(robot, contacts, point, weight=500.0):
    """Return multipliers (k,) that add up to a weight at a point of the floor, anyhow."""
    kin = robot.at(robot.q_half_sitting)
    base, J = kin.joint_placement(1), ContactStack(contacts).jacobian(kin)
    f = np.array([0.0, 0.0, weight])
    m = np.cross(point - base.translation, f)
    wrench = np.concatenate((base.rotation.T @ f, base.rotation.T @ m))
    return np.linalg.lstsq(J[:, :6].T, wrench, rcond=None)[0]


class Asked:
    """Asks a law at rest for reactions, tick by tick."""

    def __init__(self, law):
        self.law, self.t, self.F = law, 0.0, np.zeros(law.contacts.supporting_rows.size)

    def __call__(self, lam):
        """Return loads of the supports, in shares, and the reaction that is asked for."""
        law, robot = self.law, self.law.robot
        still, q = np.zeros(robot.nv), robot.q_half_sitting
        before = self.F
        command = law.step(self.t, Measurement(q, still, lam), Reference(q, still, np.zeros(0)))
        self.F, self.t = command.base_reaction, self.t + DT
        loads = law.law.loads[: len(law.contacts.contacts)].copy()
        return loads / loads.sum(), lam - before + self.F


def centre(contact):
    sole = contact.sole
    middle = 0.5 * np.array([sole.x_min + sole.x_max, sole.y_min + sole.y_max, 0.0])
    return contact.T_world_anchor.act(middle)


@pytest.mark.parametrize("share", [0.05, 0.3, 0.5, 0.8])
@pytest.mark.parametrize("bounded", [False, True])
def test_two_feet_carry_as_the_zmp_lies_between_them(hrp2, share, bounded):
    soles = sole_contacts(hrp2, hrp2.q_half_sitting)
    middles = [centre(sole) for sole in soles]
    lam = carried_at(hrp2, soles, (1.0 - share) * middles[0] + share * middles[1])
    law = law_on(hrp2, soles, bounds=ReactionBounds() if bounded else None)
    loads, reaction = Asked(law)(lam)
    assert np.allclose(loads, [1.0 - share, share], atol=1e-9)
    assert np.allclose(reaction[[2, 8]] / 500.0, [1.0 - share, share], atol=1e-6)
    for sole, middle, wrench in zip(soles, middles, (reaction[:6], reaction[6:]), strict=True):
        lever = sole.T_world_anchor.actInv(middle)
        moment = wrench[3:] - np.cross(lever, wrench[:3])
        assert np.abs(moment).max() < 1e-6 * 500.0  # it presses at its middle
    J = law.contacts.jacobian(kinematics(hrp2, hrp2.q_half_sitting))[:, :6]
    assert np.allclose(J.T @ reaction, J.T @ lam, atol=1e-9 * 500.0)


@pytest.mark.parametrize("share", [-0.3, 0.0, 1.4])
def test_a_foot_that_is_not_needed_still_feels_the_floor(hrp2, share):
    soles = sole_contacts(hrp2, hrp2.q_half_sitting)
    a, b = centre(soles[0]), centre(soles[1])
    loads, _ = Asked(law_on(hrp2, soles))(carried_at(hrp2, soles, a + share * (b - a)))
    assert 0.005 < loads.min() < 0.0101
    assert loads.sum() == pytest.approx(1.0)
    assert (loads[1] > 0.5) == (share > 0.5)


def test_three_feet_carry_as_the_zmp_lies_in_their_triangle(hrp2):
    """Barycentric coordinates, whatever the kinds of the feet; the third one stands higher."""
    q = hrp2.q_half_sitting
    soles = sole_contacts(hrp2, q)
    palm = hrp2.palms[0].frame
    p_palm = kinematics(hrp2, q).placement(palm).translation
    feet = [*soles, PointContact(name="hand", supporting=True, frame=palm, p_world=p_palm)]
    corners = np.array([centre(soles[0]), centre(soles[1]), p_palm])
    corners[:, 2] = corners[:, 2].mean()
    wanted = np.array([0.5, 0.3, 0.2])
    loads, _ = Asked(law_on(hrp2, feet))(carried_at(hrp2, feet, wanted @ corners))
    assert np.allclose(loads, wanted, atol=1e-6)


@pytest.mark.parametrize("bounded", [False, True])
def test_what_the_feet_did_to_each_other_fades_after_a_switch(hrp2, bounded):
    """The floor gives what it is asked for: what was measured at first, and less and less of it."""
    soles = sole_contacts(hrp2, hrp2.q_half_sitting)
    bounds = ReactionBounds() if bounded else None
    law = law_on(hrp2, soles, bounds=bounds, relax=0.03)
    law.switch(ContactStack(soles[:1]))
    asked = Asked(law)
    lam = carried_at(hrp2, soles, 0.6 * centre(soles[0]) + 0.4 * centre(soles[1]))
    lam += np.array([20.0, 0, 6.0, 0, 0, 0, -20.0, 0, -6.0, 0, 0, 0])  # pushing each other
    asked(lam[:6])
    law.switch(ContactStack(soles))
    still, q = np.zeros(hrp2.nv), hrp2.q_half_sitting
    asked.F = law.step(0.0, Measurement(q, still, lam), Reference(q, still, np.zeros(0))
                       ).base_reaction  # fmt: skip
    found = [lam]
    for _ in range(300):
        found.append(asked(found[-1])[1])
    size = np.abs(np.array(found) - found[-1]).max(axis=1)
    assert size[0] > 10.0
    for k in (30, 60, 90):
        assert size[k] / size[1] == pytest.approx(np.exp(-(k - 1) * DT / 0.03), rel=0.05)


def test_an_unknown_split_is_refused(hrp2):
    soles = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    with pytest.raises(InputError, match="measured"):
        PassivityController(hrp2, soles, ControlGains(K_d=1.0), DT, split="equal")
