"""Two feet: their soles, where they stand, and the ground between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.contacts import SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.robots import Robot, Sole, require_robot
from equipoise.spatial import Array
from equipoise.spatial.poses import rigid

LEFT, RIGHT = 0, 1
LEVEL = 0.02  # [rad] up to which a sole counts as level

Stance = tuple[pin.SE3, pin.SE3]


def yaw_of(T: pin.SE3) -> float:
    """Return the heading [rad] of a pose: the angle of its x axis about the vertical."""
    return math.atan2(T.rotation[1, 0], T.rotation[0, 0])


def level_pose(x: float, y: float, z: float, yaw: float) -> pin.SE3:
    """Return the pose at a point [m] with its z axis upwards and its x axis towards `yaw` [rad]."""
    return pin.SE3(pin.utils.rotate("z", yaw), np.array([x, y, z]))


@dataclass(frozen=True)
class Feet:
    """The soles of a robot that walks, left and right.

    A stance is the pair of poses of their frames; the z axis of a frame is the sole's normal.
    """

    left: Sole
    right: Sole

    @classmethod
    def of(cls, robot: Robot) -> Feet:
        """Return the two soles of a robot as they lie at half-sitting.

        Raises: `InputError` for a robot that has not two soles, or soles that do not lie level.
        """
        require_robot("the robot that walks", robot)
        if len(robot.soles) != 2:
            raise InputError(
                f"{robot.name} cannot walk: walking needs two soles",
                given=[sole.name for sole in robot.soles],
                remedy="Name both soles in the robot's YAML",
            )
        kin = robot.at(robot.q_half_sitting)
        for sole in robot.soles:
            up = kin.placement(sole.frame).rotation[2, 2]
            if up < math.cos(LEVEL):
                raise InputError(
                    f"the sole {sole.name!r} of {robot.name} is not level at half-sitting",
                    given=f"{math.degrees(math.acos(max(-1.0, min(1.0, up)))):.1f} degrees",
                    remedy="Give a half-sitting posture in which both soles lie on the floor",
                )
        first, second = robot.soles
        if kin.placement(first.frame).translation[1] < kin.placement(second.frame).translation[1]:
            first, second = second, first
        return cls(first, second)

    @property
    def soles(self) -> tuple[Sole, Sole]:
        """Left and right."""
        return self.left, self.right

    @property
    def names(self) -> tuple[str, str]:
        """Names of the soles."""
        return self.left.name, self.right.name

    def centre(self, foot: int, T_world_sole: pin.SE3) -> Array:
        """Return the middle (3,) [m] of a sole that stands at a pose."""
        return sole_corners(self.soles[foot], T_world_sole).mean(axis=0)

    def middle(self, stance: Stance) -> pin.SE3:
        """Return the level pose between two feet: between their centres, at their mean heading."""
        x, y, z = 0.5 * (self.centre(LEFT, stance[LEFT]) + self.centre(RIGHT, stance[RIGHT]))
        left, right = yaw_of(stance[LEFT]), yaw_of(stance[RIGHT])
        return level_pose(x, y, z, left + 0.5 * turn_between(left, right))

    def support(self, stance: Stance, feet: tuple[int, ...]) -> SupportPolygon:
        """Return the support polygon of those feet that stand."""
        corners = [sole_corners(self.soles[foot], stance[foot]) for foot in feet]
        return SupportPolygon.of_points(np.vstack(corners))


def turn_between(before: float, after: float) -> float:
    """Return the short turn [rad] from one heading to another."""
    return math.remainder(after - before, 2.0 * math.pi)


def with_foot(stance: Stance, foot: int, T_world_sole: pin.SE3) -> Stance:
    """Return the stance in which a foot stands elsewhere."""
    return (T_world_sole, stance[RIGHT]) if foot == LEFT else (stance[LEFT], T_world_sole)


def require_stance(feet: object, stance: object) -> None:
    """Refuse what is no pair of feet, or no pair of poses of theirs. Raises: `InputError`."""
    require_kind("the feet that walk", feet, Feet, "Say Feet.of(robot)")
    if not isinstance(stance, Sequence) or len(stance) != 2:
        raise InputError(
            "a stance is the poses of both soles, left and right", given=type(stance).__name__
        )
    for T in stance:
        rigid("the pose of a foot", T)
