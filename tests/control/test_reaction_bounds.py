"""The predicted reaction: observer against its stability bound, QP against margins and duals."""

from __future__ import annotations

import daqp
import numpy as np
import pytest
from scipy.linalg import block_diag

from equipoise.contacts import ContactStack, reaction_margins
from equipoise.control import (
    BoundedDistribution,
    DistributionStatus,
    ReactionBounds,
    ReactionObserver,
    advise_for_soft_floor,
    distribute_base_wrench,
    largest_observer_gain,
    observer_delay_margin,
)
from equipoise.control.base_wrench.foot_bounds import bounds_of
from equipoise.control.passivity.gain_advice import delay_margin
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation
from helpers import kinematics, sole_contacts


def estimate_after(gain, delay, steps=4000):
    """Return the largest error at the end of the loop `x += g (lam_0 - x delayed)`."""
    x = [0.0] * (delay + 1)
    for _ in range(steps):
        x.append(x[-1] + gain * (1.0 - x[-1 - delay]))
    return max(abs(1.0 - one) for one in x[-50:])


@pytest.mark.parametrize("delay", [0, 1, 2, 3, 5])
def test_the_bound_on_the_observer_is_where_the_loop_turns(delay):
    edge = largest_observer_gain(delay)
    assert estimate_after(0.97 * edge, delay) < 1e-3
    assert estimate_after(1.03 * edge, delay) > 1.0


def test_taken_at_face_value_no_delay_is_survived():
    assert observer_delay_margin(0.0, 1e-3) == 0.0
    margin = observer_delay_margin(0.02, 1e-3)
    gain = 1.0 - np.exp(-1.0 / 20.0)
    assert estimate_after(gain, round(margin / 1e-3), 20000) < 1e-2
    assert estimate_after(gain, round(margin / 1e-3) + 1, 40000) > 1.0


def test_the_observer_finds_a_constant_reaction_whatever_we_add(rng):
    observer = ReactionObserver(0.02, 1e-3)
    lam_0, F = rng.normal(size=12), np.zeros(12)
    for _ in range(400):
        found = observer.update(lam_0 + F, F)
        F = rng.normal(size=12)
    assert np.allclose(found, lam_0, atol=1e-6)


@pytest.mark.parametrize("delay", [0.001, 0.003, 0.008])
def test_the_adviser_keeps_its_reserve(delay):
    gains = advise_for_soft_floor(delay, 1e-3, 5.0)
    assert delay_margin(gains.kappa, gains.alpha) == pytest.approx(6.0 * (delay + 1.5e-3), rel=1e-9)
    assert 5.0 / gains.layer == pytest.approx(gains.kappa / 2.0)


@pytest.fixture
def stand(hrp2):
    q = hrp2.q_half_sitting
    soles = sole_contacts(hrp2, q)
    J = ContactStack(soles).jacobian(kinematics(hrp2, q))[:, :6]
    return soles, J


def weight(hrp2, shift=(0.0, 0.0), push=(0.0, 0.0)):
    """Return the base wrench that soles must give to hold the weight off the middle."""
    q = hrp2.q_half_sitting
    kin = kinematics(hrp2, q)
    fz = 9.81 * hrp2.mass
    p = kin.p_world_com - q[:3] + np.array([*shift, 0.0])
    force = np.array([*push, fz])
    R = kin.placement(hrp2.frame_id("BODY")).rotation
    return np.concatenate((R.T @ force, R.T @ np.cross(p, force)))


def test_an_easy_reaction_is_the_least_costly_one(hrp2, stand):
    soles, J = stand
    u = weight(hrp2)
    found = BoundedDistribution(soles)(u, J, np.zeros(12))
    costs = np.concatenate([sum(sole.reaction_costs()) for sole in soles])
    assert found.status is DistributionStatus.POSSIBLE
    assert np.allclose(found.F, distribute_base_wrench(u, J, costs, np.zeros(12)), atol=1e-6)


def test_every_answer_carries_the_base_and_is_possible(hrp2, stand, rng):
    soles, J = stand
    bounds = ReactionBounds()
    distribute = BoundedDistribution(soles, bounds)
    differed = 0
    for _ in range(200):
        u = weight(hrp2, rng.uniform((-0.06, -0.12), (0.06, 0.12)), rng.uniform(-60, 60, size=2))
        lam_0 = rng.normal(size=12) * np.tile([20.0, 20.0, 100.0, 5.0, 5.0, 3.0], 2)
        u0 = u - J.T @ lam_0
        found = distribute(u0, J, lam_0)
        assert np.allclose(J.T @ found.F, u0, atol=1e-6)
        if found.status is not DistributionStatus.POSSIBLE:
            continue
        for k, sole in enumerate(soles):
            lam = found.predicted[6 * k : 6 * k + 6]
            margins = reaction_margins(lam, sole.sole, sole.friction)
            assert margins.possible
            assert margins.normal >= bounds.normal_min - 1e-3
            assert margins.pressure >= bounds.pressure_margin - 1e-5
        costs = np.concatenate([sum(sole.reaction_costs()) for sole in soles])
        least = distribute_base_wrench(u0, J, costs, lam_0)
        spent, spent_least = (np.linalg.norm(costs * (lam_0 + F)) for F in (found.F, least))
        assert spent >= spent_least - 1e-6
        differed += spent > spent_least + 1e-3
    assert differed > 5  # the bounds did bind


def test_the_impossible_has_slack_and_a_name(hrp2, stand):
    soles, J = stand
    found = BoundedDistribution(soles)(weight(hrp2, shift=(0.5, 0.0)), J, np.zeros(12))
    assert found.status is DistributionStatus.SLACK
    assert found.slack > 10.0
    assert any("front edge" in warning for warning in found.warnings)


def test_a_foot_near_its_edge_is_reported_before_it_tips(hrp2, stand):
    soles, J = stand
    distribute = BoundedDistribution(soles)
    told = None
    for shift in np.linspace(0.0, 0.2, 81):
        found = distribute(weight(hrp2, shift=(shift, 0.0)), J, np.zeros(12))
        if told is None and any("front edge" in w for w in found.warnings):
            told = shift
        margins = [
            reaction_margins(found.predicted[6 * k : 6 * k + 6], s.sole, s.friction).pressure
            for k, s in enumerate(soles)
        ]
        if min(margins) < 0.0:
            break
    assert told is not None
    assert told < shift


def loaded_knees(hrp2, share):
    """Return how a heavy robot that leans over its right foot is shared out, and the torques."""
    q = hrp2.q_half_sitting
    soles = sole_contacts(hrp2, q)
    J = ContactStack(soles).jacobian(kinematics(hrp2, q))
    u = np.concatenate([1.6 * weight(hrp2, shift=(0.01, -0.06)), np.zeros(hrp2.na)])
    bounds = ReactionBounds(torque_share=share)
    found = BoundedDistribution(soles, bounds, hrp2)(u, J, np.zeros(12))
    tau = (u - J.T @ found.F)[6:]
    return soles, J, u, found, np.abs(tau) / hrp2.tau_max


def test_joints_that_carry_are_relieved_as_far_as_the_floor_allows(hrp2):
    *_, easy, used = loaded_knees(hrp2, 1.0)
    assert used.max() < 1.0
    share = 0.9 * used.max()
    soles, J, u, found, relieved = loaded_knees(hrp2, share)
    assert relieved.max() == pytest.approx(share, abs=1e-6)
    assert found.status is DistributionStatus.POSSIBLE
    assert np.allclose(J[:, :6].T @ found.F, u[:6], atol=1e-6)
    for k, sole in enumerate(soles):
        assert reaction_margins(
            found.predicted[6 * k : 6 * k + 6], sole.sole, sole.friction
        ).possible
    costs = np.concatenate([sum(sole.reaction_costs()) for sole in soles])
    assert np.linalg.norm(costs * found.F) > np.linalg.norm(costs * easy.F)


def test_the_relieved_distribution_is_the_optimum_of_another_solver(hrp2):
    *_, used = loaded_knees(hrp2, 1.0)
    share = 0.85 * used.max()
    soles, J, u, found, _ = loaded_knees(hrp2, share)
    costs = np.concatenate([sum(sole.reaction_costs()) for sole in soles])
    sides = [bounds_of(sole, ReactionBounds()) for sole in soles]
    A = np.vstack([J[:, :6].T, block_diag(*(side.A for side in sides)), J[:, 6:].T])
    high = np.concatenate([u[:6], np.full(sum(len(s.b) for s in sides), 1e9), share * hrp2.tau_max])
    low = np.concatenate([u[:6], *(side.b for side in sides), -share * hrp2.tau_max])
    sense = np.zeros(len(low), dtype=np.int32)
    F, _, flag, _ = daqp.solve(np.diag(costs**2), np.zeros(12), A, high, low, sense)
    assert flag == 1
    assert np.allclose(found.F, F, atol=1e-4)


def test_what_the_motors_lack_is_shared_out_and_the_floor_comes_first(hrp2):
    _, J, u, found, used = loaded_knees(hrp2, 0.1)
    assert used.max() > 0.1
    assert found.status is DistributionStatus.POSSIBLE  # of the floor
    assert np.allclose(J[:, :6].T @ found.F, u[:6], atol=1e-6)


@pytest.mark.parametrize("controller_period", [0.001, 0.002])
def test_weak_motors_that_nobody_told_of_are_borne(controller_period):
    faults = ["physics.engine=mujoco", "duration=0.9", "disturbances.mass_scale=1.7",
              "faults.torque_share=0.6", f"control.period={controller_period}"]  # fmt: skip

    def lowest(*more):
        ticks = Simulation(read_scenario("press", [*faults, *more])).ticks()
        return min(record["q"][2] - record["q_ref"][2] for _, record in ticks)

    sunk = lowest()
    assert sunk > -0.002
    assert lowest("control.torque_share=1.0") < 3.0 * sunk
