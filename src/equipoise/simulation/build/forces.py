"""The multipliers that a scenario wants, as functions of time."""

from __future__ import annotations

from equipoise.scenarios import schema
from equipoise.simulation.build.setup import pushing_hands, travel_of
from equipoise.trajectories import Profile, PushingForce, ScalarTrajectory


def wanted_forces(scenario: schema.Scenario) -> dict[str, list[ScalarTrajectory]]:
    """Return by contact the wanted multiplier of each regulated row as a function of time."""
    wanted: dict[str, list[ScalarTrajectory]] = {}
    for name, spec in scenario.contacts.items():
        if isinstance(spec, schema.GraspContactSpec):
            wanted[name] = [Profile.of(p.times, p.values) for p in spec.regulated.values()]
        elif isinstance(spec, schema.SurfaceContactSpec):
            wanted[name] = [Profile.of(spec.force.times, spec.force.values)]
        elif isinstance(spec, schema.PushContactSpec):
            wanted[name] = [_pushing_force(spec, scenario)]
        else:
            wanted[name] = []
    return wanted


def _pushing_force(spec: schema.PushContactSpec, scenario: schema.Scenario) -> PushingForce:
    slider = scenario.world.sliders[spec.slider]
    force = Profile.of(spec.force.times, spec.force.values)
    hands = len(pushing_hands(scenario)[spec.slider])
    return PushingForce(force, slider.viscosity / hands, travel_of(slider))
