"""From a scenario to contacts: one method a kind of contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

import numpy as np
import pinocchio as pin

from equipoise.contacts import (
    Contact,
    GraspContact,
    MovingSurfaceContact,
    PointContact,
    SoleContact,
    SurfaceContact,
)
from equipoise.contacts.moving import StraightMotion
from equipoise.contacts.surfaces import Cylinder, Plane, Sphere, Surface
from equipoise.errors import NameNotFoundError
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path, frame_of, to_pose, to_vector
from equipoise.trajectories import PoseTrajectory, TravelTrajectory


class _Given(TypedDict):
    """What a pushing hand's contact is told, whether its face stands or moves."""

    name: str
    regulated: tuple[str, ...]
    frame: str
    surface: Surface
    offset: tuple[float, float, float]


@dataclass(frozen=True)
class ContactMaker:
    """Makes contacts; `start` is the kinematics at half-sitting, where soles stand."""

    scenario: schema.Scenario
    robot: Robot
    start: Kinematics
    targets: dict[str, PoseTrajectory]
    handles: dict[tuple[str, str], pin.SE3]

    def make(self, name: str, spec: schema.ContactSpec, *, wanted: bool = False) -> Contact:
        """Return the contact; with `wanted` the one of the reference, where pushed faces move."""
        if isinstance(spec, schema.SoleContactSpec):
            return self._sole(name, spec)
        if isinstance(spec, schema.FootContactSpec):
            return self._foot(name, spec)
        if isinstance(spec, schema.GraspContactSpec):
            return self._grasp(name, spec)
        if isinstance(spec, schema.SurfaceContactSpec):
            return self._surface(name, spec)
        return self._push(name, spec, wanted)

    def _sole(self, name: str, spec: schema.SoleContactSpec) -> SoleContact:
        try:
            sole = self.robot.sole(spec.sole)
        except NameNotFoundError as error:
            raise at_path(error, f"contacts.{name}.sole") from None
        return SoleContact.standing(sole, self.start, name=name, friction=spec.friction)

    def _foot(self, name: str, spec: schema.FootContactSpec) -> PointContact:
        try:
            foot = self.robot.foot(spec.foot)
        except NameNotFoundError as error:
            raise at_path(error, f"contacts.{name}.foot") from None
        T = self.start.placement(foot.frame)
        down = np.array([0.0, 0.0, -foot.radius])
        x, y, z = T.rotation.T @ down
        return PointContact(
            name=name, supporting=True, frame=foot.frame, offset=(x, y, z),
            p_world=T.translation + down,
        )  # fmt: skip

    def _grasp(self, name: str, spec: schema.GraspContactSpec) -> GraspContact:
        path = f"contacts.{name}"
        for hand in spec.hands:
            if (spec.object, hand) not in self.handles:
                known = [f"{obj} by {held}" for obj, held in self.handles]
                error = NameNotFoundError("handle", f"{spec.object} by {hand}", known)
                raise at_path(error, f"{path}.hands")
        first, second = spec.hands
        T_first, T_second = self.handles[spec.object, first], self.handles[spec.object, second]
        try:
            return GraspContact(
                name=name,
                regulated=tuple(spec.regulated),
                frame_a=first,
                frame_b=second,
                T_a_b=T_first.actInv(T_second),
            )
        except NameNotFoundError as error:
            raise at_path(error, f"{path}.regulated") from None

    def _surface(self, name: str, spec: schema.SurfaceContactSpec) -> SurfaceContact:
        return SurfaceContact(
            name=name,
            regulated=("fn",),
            frame=frame_of(self.robot, spec.frame, f"contacts.{name}.frame"),
            surface=_surface_of(spec.surface),
            T_world_surface=to_pose(spec.surface.at),
            offset=to_vector(spec.offset),
        )

    def _push(self, name: str, spec: schema.PushContactSpec, wanted: bool) -> Contact:
        sliders = self.scenario.world.sliders
        if spec.slider not in sliders:
            error = NameNotFoundError("slider", spec.slider, sliders)
            raise at_path(error, f"contacts.{name}.slider")
        frame = frame_of(self.robot, spec.hand, f"contacts.{name}.hand")
        T_world_face = _face(sliders[spec.slider])
        given: _Given = {
            "name": name,
            "regulated": ("fn",),
            "frame": frame,
            "surface": Plane(),
            "offset": to_vector(spec.offset),
        }
        if not wanted:
            return SurfaceContact(T_world_surface=T_world_face, **given)
        target = self.targets[spec.slider]
        assert isinstance(target, TravelTrajectory)
        direction = to_vector(sliders[spec.slider].direction)
        motion = StraightMotion(T_world_face, direction, target.travel)
        return MovingSurfaceContact(motion=motion, **given)


def _surface_of(spec: schema.SurfaceSpec) -> Surface:
    if spec.sphere is not None:
        return Sphere(spec.sphere)
    if spec.cylinder is not None:
        return Cylinder(spec.cylinder)
    return Plane()


def _face(spec: schema.SliderSpec) -> pin.SE3:
    """Return the pose of the pushed face: z out of the object, against the direction of push."""
    direction = np.array(spec.direction)
    R = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), -direction).toRotationMatrix()
    return pin.SE3(R, np.array(spec.at.xyz) - spec.face * direction)
