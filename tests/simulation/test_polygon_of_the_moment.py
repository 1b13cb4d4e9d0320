"""The logged margin of the centre of mass is of the feet that support at that moment."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import SoleContact
from equipoise.motion.levels import polygon_of
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation


def test_the_margin_is_of_the_feet_that_support():
    simulation = Simulation(read_scenario("walk", ["duration=2.5"]))
    margins, own, alone = [], [], []
    for _, record in simulation.ticks():
        contacts = simulation.controller.contacts.contacts
        margins.append(float(record["com_margin"][0]))
        own.append(polygon_of(contacts).margin(record["com"][:2].copy()))
        alone.append(sum(isinstance(one, SoleContact) for one in contacts) == 1)
    assert np.allclose(margins, own, atol=1e-12)
    assert 700 < sum(alone) < 900  # the first step, 0.8 s in the air
    left, right = simulation.setup.contacts.contacts
    start = polygon_of([left, right]).margin(simulation.robot.at(
        simulation.assembly.q_start).p_world_com)  # fmt: skip
    assert margins[0] == start
