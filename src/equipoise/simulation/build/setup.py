"""From a scenario to robot, scene and contacts: the things that have a place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import (
    Contact,
    ContactSchedule,
    ContactStack,
    PointContact,
    SoleContact,
    SupportPolygon,
)
from equipoise.contacts.support_polygon import sole_corners
from equipoise.errors import InputError, NameNotFoundError, ScenarioError
from equipoise.robots import Robot, get_robot
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path, frame_of, to_pose, to_vector
from equipoise.simulation.build.contacts import ContactMaker
from equipoise.spatial import Array
from equipoise.trajectories import (
    AttachedTrajectory,
    CarriedTrajectory,
    FixedPose,
    PoseTrajectory,
    Travel,
    TravelTrajectory,
    Waypoint,
    WaypointTrajectory,
)
from equipoise.walking import LedPose


@dataclass(frozen=True)
class Setup:
    """Robot, scene and contacts of a scenario.

    `contacts` is every contact that ever holds, `schedule` which of them hold when, and
    `reference_schedule` the same for the reference, whose pushed objects move as wanted.
    `targets` are the wanted ways of objects and sliders; `sliders` are unit vectors (3,) along
    which sliders go, `pushing` the hands that push each of them. `carrier` is how a walk displaces
    what it carries along, None where the robot stands. Nothing carries a robot whose base is fixed:
    it has no `soles` and no `polygon`.
    """

    robot: Robot
    scene: Scene
    soles: ContactStack
    contacts: ContactStack
    schedule: ContactSchedule
    reference_schedule: ContactSchedule
    polygon: SupportPolygon | None
    targets: dict[str, PoseTrajectory]
    handles: dict[tuple[str, str], pin.SE3]
    sliders: dict[str, Array]
    pushing: dict[str, tuple[str, ...]]
    carrier: LedPose | None = None

    def scene_with(self, travels: Mapping[str, float]) -> Scene:
        """Return the scene with each slider moved on by its travel [m]."""
        if not travels:
            return self.scene
        bodies = []
        for body in self.scene.bodies:
            if body.name in travels:
                T = body.T_parent_body
                way = travels[body.name] * self.sliders[body.name]
                body = replace(body, T_parent_body=pin.SE3(T.rotation, T.translation + way))
            bodies.append(body)
        return Scene(self.robot, bodies)

    def hand_trajectory(self, hand: str, obj: str) -> AttachedTrajectory:
        """Return how a palm moves that holds an object."""
        return AttachedTrajectory(self.targets[obj], self.handles[obj, hand])


def build_setup(scenario: schema.Scenario, robot: Robot | None = None) -> Setup:
    """Return robot, scene and contacts; `robot` is loaded unless it is given.

    Raises: `ScenarioError` naming the path of a wrong name.
    """
    robot = robot or get_robot(scenario.robot)
    carrier = None if scenario.walk is None else LedPose(pin.SE3.Identity())
    targets = _targets(scenario, carrier)
    handles = {
        (name, hand): to_pose(spec)
        for name, obj in scenario.world.objects.items()
        for hand, spec in obj.handles.items()
    }
    for obj, hand in handles:
        frame_of(robot, hand, f"world.objects.{obj}.handles.{hand}")
    scene = _scene(scenario, robot, handles)
    start = robot.at(robot.q_half_sitting)
    makers = ContactMaker(scenario, robot, start, targets, handles)
    contacts = [makers.make(name, spec) for name, spec in scenario.contacts.items()]
    reference = [makers.make(name, spec, wanted=True) for name, spec in scenario.contacts.items()]
    windows = {
        name: (spec.start, spec.end)
        for name, spec in scenario.contacts.items()
        if isinstance(spec, schema.PushContactSpec)
    }
    for name, spec in scenario.contacts.items():
        if isinstance(spec, schema.GraspContactSpec) and spec.end is not None:
            windows[name] = (-np.inf, spec.end)
        elif isinstance(spec, schema.SurfaceContactSpec) and spec.comes_or_goes:
            windows[name] = (
                -np.inf if spec.start is None else spec.start,
                np.inf if spec.end is None else spec.end,
            )
    soles = [c for c in contacts if c.supporting]
    _require_support(robot, soles)
    return Setup(
        robot,
        scene,
        ContactStack(soles),
        ContactStack(contacts),
        ContactSchedule(contacts, windows),
        ContactSchedule(reference, windows),
        _polygon(soles),
        targets,
        handles,
        {name: np.array(spec.direction) for name, spec in scenario.world.sliders.items()},
        pushing_hands(scenario),
        carrier,
    )


def _require_support(robot: Robot, soles: list[Contact]) -> None:
    """Refuse a floating base that nothing carries, and a fixed one that stands besides."""
    if robot.nv_base and not soles:
        raise ScenarioError(
            "no sole stands on the floor",
            path="contacts",
            known=[*(sole.name for sole in robot.soles), *(foot.name for foot in robot.feet)],
            remedy="Add a contact of kind sole or foot, or say base: fixed in the robot's YAML",
        )
    if soles and not robot.nv_base:
        raise ScenarioError(
            f"the base of {robot.name} is fixed to the world; it needs no sole or foot",
            path=f"contacts.{soles[0].name}",
            remedy="Leave the contact out, or say base: floating in the robot's YAML",
        )


def _polygon(supports: list[Contact]) -> SupportPolygon | None:
    corners = [
        sole_corners(c.sole, c.T_world_anchor) for c in supports if isinstance(c, SoleContact)
    ]
    corners += [np.array([c.p_world]) for c in supports if isinstance(c, PointContact)]
    return SupportPolygon.of_points(np.vstack(corners)) if corners else None


def pushing_hands(scenario: schema.Scenario) -> dict[str, tuple[str, ...]]:
    """Return by slider the hands that push it."""
    pushes = [c for c in scenario.contacts.values() if isinstance(c, schema.PushContactSpec)]
    return {
        name: tuple(push.hand for push in pushes if push.slider == name)
        for name in scenario.world.sliders
    }


def check_object(scenario: schema.Scenario, name: str, path: str) -> None:
    """Refuse an object that the world does not have."""
    if name not in scenario.world.objects:
        raise at_path(NameNotFoundError("object", name, scenario.world.objects), path)


def check_target(setup: Setup, name: str, path: str) -> None:
    """Refuse a name that is neither an object nor a slider of the world."""
    if name not in setup.targets:
        raise at_path(NameNotFoundError("object or slider", name, setup.targets), path)


def check_handle(scenario: schema.Scenario, obj: str, hand: str, path: str) -> None:
    """Refuse a hand that does not hold the object."""
    check_object(scenario, obj, path)
    handles = scenario.world.objects[obj].handles
    if hand not in handles:
        raise at_path(NameNotFoundError(f"handle of {obj!r} named", hand, handles), path)


def to_waypoints(specs: list[schema.WaypointSpec]) -> WaypointTrajectory:
    """Return the trajectory through the waypoints of a scenario."""
    return WaypointTrajectory([Waypoint(w.t, to_pose(w), w.stop) for w in specs])


def travel_of(slider: schema.SliderSpec) -> Travel:
    """Return how a slider is wanted to go."""
    return Travel(slider.travel.start, slider.travel.end, slider.travel.distance)


def carried_by(carrier: LedPose | None, path: PoseTrajectory, where: str) -> CarriedTrajectory:
    """Return the path as it goes along with a walk. Raises: `ScenarioError` where there is none."""
    if carrier is None:
        raise ScenarioError(
            "only a robot that walks carries something along",
            path=where,
            remedy="Leave carried out, or add a section walk",
        )
    return CarriedTrajectory(carrier, path)


def _targets(scenario: schema.Scenario, carrier: LedPose | None) -> dict[str, PoseTrajectory]:
    targets: dict[str, PoseTrajectory] = {}
    for name, obj in scenario.world.objects.items():
        targets[name] = to_waypoints(obj.waypoints)
        if obj.carried:
            path = f"world.objects.{name}.carried"
            targets[name] = carried_by(carrier, targets[name], path)
    for name, slider in scenario.world.sliders.items():
        targets[name] = TravelTrajectory(
            FixedPose(to_pose(slider.at)), np.array(slider.direction), travel_of(slider)
        )
    return targets


def _shapes(specs: list[schema.ShapeSpec]) -> tuple[Shape, ...]:
    shapes = []
    for spec in specs:
        red, green, blue, alpha = spec.colour
        if spec.box is not None:
            kind, size = "box", to_vector(spec.box)
        elif spec.sphere is not None:
            kind, size = "sphere", (2.0 * spec.sphere, 2.0 * spec.sphere, 2.0 * spec.sphere)
        else:
            radius, height = spec.cylinder or (0.0, 0.0)
            kind, size = "cylinder", (2.0 * radius, 2.0 * radius, height)
        shapes.append(Shape(kind, size, to_pose(spec.at), (red, green, blue, alpha)))
    return tuple(shapes)


def _scene(
    scenario: schema.Scenario, robot: Robot, handles: dict[tuple[str, str], pin.SE3]
) -> Scene:
    world = scenario.world
    bodies = [
        Body(name, _shapes(one.shapes), to_pose(one.at)) for name, one in world.bodies.items()
    ]
    bodies += [
        Body(name, _shapes(one.shapes), to_pose(one.at)) for name, one in world.sliders.items()
    ]
    for name, spec in world.objects.items():
        first = next(iter(spec.handles))
        bodies.append(Body(name, _shapes(spec.shapes), handles[name, first].inverse(), first))
    try:
        return Scene(robot, bodies)
    except InputError as error:
        raise at_path(error, "world") from None
