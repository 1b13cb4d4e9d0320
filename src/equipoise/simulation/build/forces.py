"""The multipliers that a scenario wants, as functions of time."""

from __future__ import annotations

from collections.abc import Callable

from equipoise.control import Profile
from equipoise.scenarios import schema
from equipoise.simulation.build.setup import Setup


def wanted_forces(
    scenario: schema.Scenario, setup: Setup
) -> dict[str, list[Callable[[float], float]]]:
    """Return by contact the wanted multiplier of each regulated row as a function of time."""
    wanted: dict[str, list[Callable[[float], float]]] = {}
    for name, spec in scenario.contacts.items():
        if isinstance(spec, schema.GraspContactSpec):
            wanted[name] = [Profile.of(p.times, p.values).at for p in spec.regulated.values()]
        elif isinstance(spec, schema.SurfaceContactSpec):
            wanted[name] = [Profile.of(spec.force.times, spec.force.values).at]
        elif isinstance(spec, schema.PushContactSpec):
            wanted[name] = [_pushing_force(spec, scenario, setup)]
        else:
            wanted[name] = []
    return wanted


def _pushing_force(
    spec: schema.PushContactSpec, scenario: schema.Scenario, setup: Setup
) -> Callable[[float], float]:
    profile = Profile.of(spec.force.times, spec.force.values)
    slider, target = scenario.world.sliders[spec.slider], setup.targets[spec.slider]
    return lambda t: profile.at(t) + slider.viscosity * target.travel(t)[1]
