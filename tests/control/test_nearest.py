"""The projector that is orthogonal in K_d: its identities, the law under it, the adviser's rule."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.contacts import ContactStack
from equipoise.control import (
    BoundedDistribution,
    ControlGains,
    Measurement,
    NearestVelocity,
    PassivityController,
    Reference,
    advise_for_soft_floor,
    distribute_base_wrench,
)
from equipoise.control.passivity.gain_advice import RESERVES, delay_margin
from equipoise.errors import InputError
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.gains import gains_of
from equipoise.simulation.simulation import Simulation
from helpers import sole_contacts


def metric(rng, n: int):
    A = rng.normal(size=(n, n))
    return A @ A.T + 0.1 * np.eye(n)


@pytest.mark.parametrize(("rows", "doubled"), [(1, 0), (5, 0), (5, 3), (12, 0)])
def test_it_is_the_projector_of_its_metric(rng, rows, doubled):
    n = 12
    K, J = metric(rng, n), rng.normal(size=(rows, n))
    J = np.vstack((J, rng.normal(size=(doubled, rows)) @ J))
    near = NearestVelocity(J, K)
    assert near.rank == rows
    N = near.N
    assert np.allclose(J @ N, 0.0, atol=1e-9)
    assert np.allclose(N @ N, N, atol=1e-9)
    assert np.allclose(K @ N, (K @ N).T, atol=1e-8)
    assert np.linalg.eigvalsh(K @ N).min() > -1e-9
    assert np.allclose(J @ near.J_sharp @ J, J, atol=1e-9)


def test_no_other_velocity_on_the_contacts_is_nearer(rng):
    K, J = metric(rng, 9), rng.normal(size=(4, 9))
    x, y = rng.normal(size=9), rng.normal(size=4)
    z = NearestVelocity(J, K).move(x, y)
    assert np.allclose(J @ z, y)
    free = np.linalg.svd(J)[2][4:].T
    for _ in range(50):
        other = z + free @ rng.normal(size=5)
        assert (other - x) @ K @ (other - x) > (z - x) @ K @ (z - x)


def test_with_a_multiple_of_one_it_is_the_printed_projector(rng):
    J = rng.normal(size=(4, 9))
    near, J_pinv = NearestVelocity(J, 7.0 * np.eye(9)), np.linalg.pinv(J)
    assert np.allclose(near.N, np.eye(9) - J_pinv @ J)
    assert np.allclose(near.J_sharp, J_pinv)


@pytest.mark.parametrize("projector", ["euclidean", "damping"])
def test_on_a_scalar_damping_both_laws_are_one(hrp2, rng, projector):
    q = hrp2.q_half_sitting
    stack = ContactStack(sole_contacts(hrp2, q))
    law = PassivityController(hrp2, stack, ControlGains(K_d=30.0, projector=projector), 0.001)
    printed = PassivityController(hrp2, stack, ControlGains(K_d=30.0), 0.001)
    for k in range(5):
        measured = Measurement(q, 0.1 * rng.normal(size=hrp2.nv), rng.normal(size=12))
        wanted = Reference(q, np.zeros(hrp2.nv), np.zeros(0))
        taus = [one.step(0.001 * k, measured, wanted).tau for one in (law, printed)]
        assert np.allclose(*taus, atol=1e-9)


def test_memory_goes_on_to_the_bit_under_both(hrp2, rng):
    q = hrp2.q_half_sitting
    stack = ContactStack(sole_contacts(hrp2, q))
    K = metric(rng, hrp2.nv)
    gains = ControlGains(K_d=K, projector="damping", damp_violation=True)
    first, second = (PassivityController(hrp2, stack, gains, 0.001) for _ in range(2))
    wanted = Reference(q, np.zeros(hrp2.nv), np.zeros(0))

    def measured():
        return Measurement(q, 0.1 * rng.normal(size=hrp2.nv), rng.normal(size=12))

    for k in range(3):
        first.step(0.001 * k, measured(), wanted)
    second.restore(first.state())
    last = measured()
    taus = [law.step(0.003, last, wanted).tau for law in (first, second)]
    assert np.array_equal(*taus)


def test_an_unknown_projector_is_refused_with_those_that_exist():
    with pytest.raises(InputError, match="euclidean") as told:
        ControlGains(K_d=1.0, projector="orthogonal")
    assert "damping" in str(told.value)


def test_the_adviser_leaves_each_projector_its_reserve():
    for projector, reserve in RESERVES.items():
        gains = advise_for_soft_floor(0.003, 0.001, 5.0, projector=projector)
        assert delay_margin(gains.kappa, gains.alpha) == pytest.approx(reserve * 0.0045)


def test_a_scenario_takes_the_metric_where_floors_are_real():
    def chosen(*overrides):
        return gains_of(read_scenario("press", overrides)).projector

    assert chosen() == "euclidean"
    assert chosen("physics.engine=mujoco") == "damping"
    assert chosen("physics.engine=mujoco", "control.soft_floor_delay=0") == "euclidean"
    assert chosen("physics.engine=mujoco", "control.gains.projector=euclidean") == "euclidean"
    assert chosen("control.gains.projector=damping") == "damping"


def test_bounds_that_are_not_met_change_nothing_at_unequal_loads(hrp2, rng):
    q = hrp2.q_half_sitting
    soles = sole_contacts(hrp2, q)
    J = ContactStack(soles).jacobian(hrp2.at(q))[:, :6]
    equal = np.concatenate([sum(sole.reaction_costs()) for sole in soles])
    lam = np.tile([0.0, 0.0, 280.0, 0.0, 0.0, 0.0], 2)
    for share in (0.6, 1.0, 1.5):
        costs = equal * np.repeat([share, 1.0 / share], 6)
        found = BoundedDistribution(soles)(J.T @ lam, J, np.zeros(12), costs)
        least = distribute_base_wrench(J.T @ lam, J, costs, np.zeros(12))
        assert np.allclose(found.F, least, atol=1e-6)


FAULTS = (
    "physics.engine=mujoco",
    "duration=1.2",
    "faults.measurement_delay=0.003",
    "disturbances.payloads=[{frame: right_palm, mass: 5}]",
    "control.soft_floor_delay=0",
    "control.gains.damp_violation=true",
    "control.gains.kappa=100",
    "control.gains.sgn_p={kind: saturation, layer: 0.1}",
)


@pytest.mark.parametrize(("projector", "stands"), [("damping", True), ("euclidean", False)])
def test_on_a_real_floor_only_the_metric_bears_the_gain(projector, stands):
    sim = Simulation(read_scenario("press", [*FAULTS, f"control.gains.projector={projector}"]))
    lowest = min(record["q"][2] - record["q_ref"][2] for _, record in sim.ticks())
    assert bool(lowest > -0.02) is stands
