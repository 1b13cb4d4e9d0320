"""Refuse what can be seen to be impossible before anything moves: who is to blame, by name."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin

from equipoise.collision.scene import Body
from equipoise.contacts import ContactStack
from equipoise.errors import ScenarioError
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import to_pose
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array


def check_waypoints(scenario: schema.Scenario, setup: Setup) -> None:
    """Refuse a waypoint at which a held object would stick in a fixed body.

    Where an object is that a walk carries along, only the walk knows.
    Raises: `ScenarioError` with the path of the waypoint and the body.
    """
    bodies = {body.name: body for body in setup.scene.bodies}
    fixed = [b for b in bodies.values() if b.frame is None and b.name not in setup.sliders]
    for name, spec in scenario.world.objects.items():
        for i, waypoint in enumerate(() if spec.carried else spec.waypoints):
            for body in fixed:
                depth = -_distance(bodies[name], to_pose(waypoint), body)
                if depth > 0.0:
                    raise ScenarioError(
                        f"{name} would be {1e3 * depth:.1f} mm inside {body.name}",
                        path=f"world.objects.{name}.waypoints.{i}",
                        given=list(waypoint.xyz),
                        remedy="Move the waypoint out of it",
                    )


def check_contacts(setup: Setup, q: Array, reference: ContactStack) -> None:
    """Refuse contacts that cannot hold together at the starting posture `q` (nq,).

    Raises: `ScenarioError` naming the contact.
    """
    kin = setup.robot.at(q)
    culprits = reference.contradictions(kin, tolerance=1e-4)
    if culprits:
        raise ScenarioError(
            "this contact cannot hold together with those before it",
            path=f"contacts.{culprits[0]}",
            known=list(reference.rows),
            remedy="Move it to where the robot starts, or start elsewhere",
        )


def _distance(held: Body, T_world_held: pin.SE3, fixed: Body) -> float:
    least = np.inf
    for a in held.shapes:
        T_a = _transform(T_world_held * a.T_body_shape)
        for b in fixed.shapes:
            T_b = _transform(fixed.T_parent_body * b.T_body_shape)
            result = coal.DistanceResult()
            request = coal.DistanceRequest()
            least = min(least, coal.distance(a.geometry(), T_a, b.geometry(), T_b, request, result))
    return float(least)


def _transform(T: pin.SE3) -> coal.Transform3s:
    return coal.Transform3s(T.rotation, T.translation)
