"""What a robot's first link may do: move freely, or be fixed to the world."""

from __future__ import annotations

from dataclasses import dataclass

import pinocchio as pin

from equipoise.errors import RobotFileError
from equipoise.kinematics.followers import MIMIC, moving_joints


@dataclass(frozen=True)
class Base:
    """A kind of base: the names and units of its entries of q and v, which stand before the joints.

    `first_joint` is Pinocchio's index of the first joint after it.
    """

    kind: str
    position_names: tuple[str, ...]
    position_units: tuple[str, ...]
    velocity_names: tuple[str, ...]
    velocity_units: tuple[str, ...]
    first_joint: int

    @property
    def nq(self) -> int:
        """Return how many entries of a configuration belong to the base."""
        return len(self.position_names)

    @property
    def nv(self) -> int:
        """Return how many entries of a velocity belong to the base."""
        return len(self.velocity_names)


FLOATING = Base(
    "floating",
    ("x", "y", "z", "qx", "qy", "qz", "qw"),
    (*("m",) * 3, *("",) * 4),
    ("base_x", "base_y", "base_z", "base_roll", "base_pitch", "base_yaw"),
    (*("m/s",) * 3, *("rad/s",) * 3),
    first_joint=2,
)
FIXED = Base("fixed", (), (), (), (), first_joint=1)
BASES = {base.kind: base for base in (FLOATING, FIXED)}


def base_of(model: pin.Model) -> Base:
    """Return the kind of base that a model has: floating if its first joint is free."""
    free = model.njoints > 1 and (model.joints[1].nq, model.joints[1].nv) == (7, 6)
    return FLOATING if free else FIXED


def actuated_joints(model: pin.Model) -> list[int]:
    """Return the joints that have a coordinate of their own, after the base, in its order."""
    return [j for j in moving_joints(model) if j >= base_of(model).first_joint]


def require_joints_of_one_dof(model: pin.Model) -> None:
    """Refuse a model that is not a base followed by joints with one q and one v each.

    Raises: RobotFileError.
    """
    first = base_of(model).first_joint
    if model.njoints <= 1:
        raise RobotFileError(
            "The robot has a fixed base and no joint that moves: there is nothing to control",
            remedy="Say base: floating in the robot's YAML, or unlock a joint",
        )
    for joint, name in zip(model.joints[first:], list(model.names)[first:], strict=True):
        if (joint.nq, joint.nv) != (1, 1) and joint.shortname() != MIMIC:
            raise RobotFileError(
                f"Joint {name!r} has {joint.nq} coordinates and {joint.nv} speeds, wanted 1 and 1",
                given=joint.shortname(),
                remedy="Make it revolute or prismatic with limits, or fixed",
            )
