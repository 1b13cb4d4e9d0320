"""From a scenario to robot, scene and contacts: the things that have a place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.contacts import Contact, ContactStack, GraspContact, SoleContact, SupportPolygon
from equipoise.contacts.support import sole_corners
from equipoise.errors import InputError, NameNotFoundError, ScenarioError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import Robot, get_robot
from equipoise.scenarios import schema
from equipoise.spatial import pose
from equipoise.tasks import AttachedTrajectory, Waypoint, WaypointTrajectory
from equipoise.world import Body, Scene, Shape


@dataclass(frozen=True)
class Places:
    """Robot, scene and contacts of a scenario; `half_sitting` is its pose before it moves."""

    robot: Robot
    scene: Scene
    soles: ContactStack
    contacts: ContactStack
    polygon: SupportPolygon
    objects: dict[str, WaypointTrajectory]
    handles: dict[tuple[str, str], pin.SE3]

    def hand_trajectory(self, hand: str, obj: str) -> AttachedTrajectory:
        """Return how a palm moves that holds an object."""
        return AttachedTrajectory(self.objects[obj], self.handles[obj, hand])


def build_places(scenario: schema.Scenario) -> Places:
    """Return robot, scene and contacts. Raises: `ScenarioError` naming the path of a wrong name."""
    robot = get_robot(scenario.robot)
    objects = {name: _trajectory(spec) for name, spec in scenario.world.objects.items()}
    handles = {
        (name, hand): to_pose(spec)
        for name, obj in scenario.world.objects.items()
        for hand, spec in obj.handles.items()
    }
    for obj, hand in handles:
        frame_of(robot, hand, f"world.objects.{obj}.handles.{hand}")
    scene = _scene(scenario, robot, handles)
    start = KinematicsEvaluator(robot).at(robot.q_half_sitting, np.zeros(robot.nv))
    contacts: dict[str, Contact] = {}
    for name, spec in scenario.contacts.items():
        if isinstance(spec, schema.SoleContactSpec):
            contacts[name] = _sole(name, spec, robot, start)
        else:
            contacts[name] = _grasp(name, spec, robot, handles)
    soles = [c for c in contacts.values() if isinstance(c, SoleContact)]
    if not soles:
        raise ScenarioError(
            "no sole stands on the floor",
            path="contacts",
            known=[sole.name for sole in robot.soles],
            remedy="Add a contact of kind sole",
        )
    corners = np.vstack([sole_corners(c.sole, c.T_world_anchor) for c in soles])
    return Places(
        robot,
        scene,
        ContactStack(soles),
        ContactStack(list(contacts.values())),
        SupportPolygon.of_points(corners),
        objects,
        handles,
    )


def to_pose(spec: schema.Pose) -> pin.SE3:
    """Return the placement that a `Pose` section describes."""
    return pose(spec.xyz, spec.rpy)


def frame_of(robot: Robot, name: str, path: str) -> int:
    """Return the id of a frame of the robot. Raises: `ScenarioError` with the path."""
    try:
        return robot.frame_id(name)
    except NameNotFoundError as error:
        raise at_path(error, path) from None


def at_path(error: InputError, path: str) -> ScenarioError:
    """Return the same complaint with the path of the scenario where it comes from."""
    return ScenarioError(
        error.problem, path=path, given=error.given, known=error.known, remedy=error.remedy
    )


def check_object(scenario: schema.Scenario, name: str, path: str) -> None:
    """Refuse an object that the world does not have."""
    if name not in scenario.world.objects:
        raise at_path(NameNotFoundError("object", name, scenario.world.objects), path)


def check_handle(scenario: schema.Scenario, obj: str, hand: str, path: str) -> None:
    """Refuse a hand that does not hold the object."""
    check_object(scenario, obj, path)
    handles = scenario.world.objects[obj].handles
    if hand not in handles:
        raise at_path(NameNotFoundError(f"handle of {obj!r} named", hand, handles), path)


def _trajectory(spec: schema.HeldObject) -> WaypointTrajectory:
    return WaypointTrajectory([Waypoint(w.t, to_pose(w), w.stop) for w in spec.waypoints])


def _shapes(specs: list[schema.ShapeSpec]) -> tuple[Shape, ...]:
    shapes = []
    for spec in specs:
        colour = tuple(spec.colour)
        if spec.box is not None:
            shapes.append(Shape("box", tuple(spec.box), to_pose(spec.at), colour))
        else:
            radius, height = spec.cylinder or (0.0, 0.0)
            size = (2.0 * radius, 2.0 * radius, height)
            shapes.append(Shape("cylinder", size, to_pose(spec.at), colour))
    return tuple(shapes)


def _scene(
    scenario: schema.Scenario, robot: Robot, handles: dict[tuple[str, str], pin.SE3]
) -> Scene:
    bodies = [
        Body(name, _shapes(spec.shapes), to_pose(spec.at))
        for name, spec in scenario.world.bodies.items()
    ]
    for name, spec in scenario.world.objects.items():
        first = next(iter(spec.handles))
        bodies.append(Body(name, _shapes(spec.shapes), handles[name, first].inverse(), first))
    try:
        return Scene(robot, bodies)
    except InputError as error:
        raise at_path(error, "world") from None


def _sole(name: str, spec: schema.SoleContactSpec, robot: Robot, start) -> SoleContact:
    try:
        sole = robot.sole(spec.sole)
    except NameNotFoundError as error:
        raise at_path(error, f"contacts.{name}.sole") from None
    frame_id = robot.frame_id(sole.frame)
    return SoleContact(
        name=name,
        supporting=True,
        sole=sole,
        friction=spec.friction,
        frame_id=frame_id,
        T_world_anchor=start.placement(frame_id),
    )


def _grasp(
    name: str,
    spec: schema.GraspContactSpec,
    robot: Robot,
    handles: dict[tuple[str, str], pin.SE3],
) -> GraspContact:
    path = f"contacts.{name}"
    for hand in spec.hands:
        if (spec.object, hand) not in handles:
            known = [f"{obj} by {held}" for obj, held in handles]
            error = NameNotFoundError("handle", f"{spec.object} by {hand}", known)
            raise at_path(error, f"{path}.hands")
    first, second = spec.hands
    try:
        return GraspContact(
            name=name,
            regulated=tuple(spec.regulated),
            frame_a=robot.frame_id(first),
            frame_b=robot.frame_id(second),
            T_a_b=handles[spec.object, first].actInv(handles[spec.object, second]),
        )
    except NameNotFoundError as error:
        raise at_path(error, f"{path}.regulated") from None
