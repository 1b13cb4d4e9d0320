"""The frozen robot that everything else is given: names, limits, frames, soles and palms."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError, NameNotFoundError, NonFiniteError
from equipoise.given import require_kind
from equipoise.kinematics import Kinematics, kinematics_at
from equipoise.kinematics.followers import followers_of, moved_by
from equipoise.robots.base import Base, actuated_joints, base_of, require_joints_of_one_dof


@dataclass(frozen=True)
class Sole:
    """A flat rectangle that may stand on the ground: z of `frame` points up out of the ground.

    The bounds [m] are in the axes of `frame`; the rectangle lies in its plane z = 0.
    """

    name: str
    frame: str
    x_min: float
    x_max: float
    y_min: float
    y_max: float

    @property
    def corners(self) -> np.ndarray:
        """Return the corners [m] (4, 3) in the sole frame, anticlockwise seen from above."""
        x0, x1, y0, y1 = self.x_min, self.x_max, self.y_min, self.y_max
        return _read_only([[x1, y1, 0.0], [x0, y1, 0.0], [x0, y0, 0.0], [x1, y0, 0.0]])


@dataclass(frozen=True)
class Palm:
    """A hand's contact frame: x along the fingers, z the palm's normal out of the hand.

    The hand's surface lies `skin` [m] out along z.
    """

    name: str
    frame: str
    skin: float = 0.0


@dataclass(frozen=True)
class Foot:
    """A foot that touches the ground in a point: `radius` [m] below the origin of its frame."""

    name: str
    frame: str
    radius: float = 0.0


Surface = TypeVar("Surface", Sole, Palm, Foot)


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """Hold a checked robot with a floating or a fixed base.

    Configurations q (nq,) are [base position, base quaternion xyzw, joints]; velocities v (nv,)
    are [base linear, base angular, both in base axes, joint rates]. With a fixed base both are
    joints only, and the first link stands at the origin of the world. Build it with `get_robot` or
    `load_robot`. Treat `model` and the geometry models as read-only: copies with other masses
    come from `scaled`, `with_payload` and `with_unit_inertias`. `parts` are the links of the parts
    of the body ("left_forearm"), which robots have in common; `postures` what the description
    calls one: name -> joint -> coordinate [rad or m].
    """

    name: str
    model: pin.Model
    collision_model: pin.GeometryModel
    visual_model: pin.GeometryModel
    urdf_path: Path
    soles: tuple[Sole, ...]
    palms: tuple[Palm, ...]
    camera: str | None
    q_half_sitting: np.ndarray
    parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    postures: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    feet: tuple[Foot, ...] = ()

    def __post_init__(self) -> None:
        require_joints_of_one_dof(self.model)
        object.__setattr__(self, "q_half_sitting", _read_only(self.q_half_sitting))
        surfaces: tuple[Sole | Palm | Foot, ...] = (*self.soles, *self.palms, *self.feet)
        for surface in surfaces:
            self.frame_id(surface.frame)
        if self.camera is not None:
            self.frame_id(self.camera)
        for link in (link for links in self.parts.values() for link in links):
            self.frame_id(link)

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, {self.na} joints, {self.mass:.3f} kg, {self.urdf_path})"

    @cached_property
    def nq(self) -> int:
        """Return the length of a configuration."""
        return self.model.nq

    @cached_property
    def nv(self) -> int:
        """Return the length of a velocity."""
        return self.model.nv

    @cached_property
    def base(self) -> Base:
        """Return the kind of base: `robot.base.kind` is "floating" or "fixed"."""
        return base_of(self.model)

    @cached_property
    def nq_base(self) -> int:
        """Return how many entries of a configuration belong to the base."""
        return self.base.nq

    @cached_property
    def nv_base(self) -> int:
        """Return how many entries of a velocity belong to the base."""
        return self.base.nv

    @property
    def base_position_names(self) -> tuple[str, ...]:
        """Return a name for each entry of a configuration that belongs to the base."""
        return self.base.position_names

    @property
    def base_position_units(self) -> tuple[str, ...]:
        """Return their units."""
        return self.base.position_units

    @property
    def base_velocity_units(self) -> tuple[str, ...]:
        """Return the unit of each entry of a velocity that belongs to the base."""
        return self.base.velocity_units

    @cached_property
    def na(self) -> int:
        """Return the number of actuated joints."""
        return self.model.nv - self.nv_base

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Return the actuated joints in the order of v[nv_base:]."""
        return tuple(self.model.names[joint] for joint in self.actuated)

    @cached_property
    def actuated(self) -> tuple[int, ...]:
        """Return Pinocchio's indices of the actuated joints, in the order of v[nv_base:].

        Joints that follow others are left out: they have no coordinate of their own.
        """
        return tuple(actuated_joints(self.model))

    @cached_property
    def followers(self) -> Mapping[str, tuple[str, float, float]]:
        """Return by name the joints that follow another: its name, ratio, and offset [rad or m]."""
        names = self.model.names
        return {
            names[one.joint]: (names[one.leader], one.ratio, one.offset)
            for one in followers_of(self.model)
        }

    @cached_property
    def velocity_names(self) -> tuple[str, ...]:
        """Return a name for each entry of v."""
        return (*self.base.velocity_names, *self.joint_names)

    @cached_property
    def frame_names(self) -> tuple[str, ...]:
        """Return the names of all frames."""
        return tuple(frame.name for frame in self.model.frames)

    @cached_property
    def q_min(self) -> np.ndarray:
        """Return the lower joint limits [rad or m] (na,)."""
        return _read_only(self.model.lowerPositionLimit[self.nq_base :])

    @cached_property
    def q_max(self) -> np.ndarray:
        """Return the upper joint limits [rad or m] (na,)."""
        return _read_only(self.model.upperPositionLimit[self.nq_base :])

    @cached_property
    def v_max(self) -> np.ndarray:
        """Return the joint speed limits [rad/s or m/s] (na,), all positive."""
        return _read_only(self.model.upperVelocityLimit[self.nv_base :])

    @cached_property
    def tau_max(self) -> np.ndarray:
        """Return the joint torque limits [N m or N] (na,), all positive."""
        return _read_only(self.model.upperEffortLimit[self.nv_base :])

    @cached_property
    def mass(self) -> float:
        """Return the mass [kg] of all that moves: a fixed first link is left out."""
        return float(sum(inertia.mass for inertia in self.model.inertias[1:]))

    def joints_between(self, frame: str | int) -> tuple[int, ...]:
        """Return the actuated joints between the base and a frame, by their place in v[nv_base:].

        Raises: NameNotFoundError, InputError.
        """
        joint = self.model.frames[self.frame_id(frame)].parentJoint
        base = self.nv_base
        return tuple(c - base for c in moved_by(self.model, joint) if c >= base)

    def frame_id(self, frame: str | int) -> int:
        """Return Pinocchio's index of a frame by its name, or the index itself if there is one.

        Raises: NameNotFoundError, InputError.
        """
        if isinstance(frame, str):
            if frame not in self._frame_ids:
                raise NameNotFoundError(f"frame on robot {self.name}:", frame, self._frame_ids)
            return self._frame_ids[frame]
        if isinstance(frame, bool) or not isinstance(frame, int | np.integer):
            raise InputError("a frame is given by its name", given=frame, known=self.frame_names)
        if not 0 <= frame < self.model.nframes:
            raise InputError(
                f"robot {self.name} has {self.model.nframes} frames; there is none of this index",
                given=int(frame),
                remedy="Give the name of a frame; `robot.frame_names` lists them",
            )
        return int(frame)

    def at(self, q: np.ndarray, v: np.ndarray | None = None, t: float = 0.0) -> Kinematics:
        """Return the kinematics at configuration `q` (nq,) and velocity `v` (nv,), zero if None.

        Raises: ShapeError, NonFiniteError, InputError.
        """
        return kinematics_at(self, q, v, t)

    def joint_index(self, name: str) -> int:
        """Return where a joint stands among the actuated ones, 0 <= index < na.

        Raises: NameNotFoundError.
        """
        if name not in self.joint_names:
            raise NameNotFoundError(f"actuated joint on robot {self.name}:", name, self.joint_names)
        return self.joint_names.index(name)

    def sole(self, name: str) -> Sole:
        """Return a sole by name.

        Raises: NameNotFoundError.
        """
        return _by_name(f"sole on robot {self.name}:", name, self.soles)

    def foot(self, name: str) -> Foot:
        """Return a foot that is a point, by name.

        Raises: NameNotFoundError.
        """
        return _by_name(f"foot on robot {self.name}:", name, self.feet)

    def palm(self, name: str) -> Palm:
        """Return a palm by name.

        Raises: NameNotFoundError.
        """
        return _by_name(f"palm on robot {self.name}:", name, self.palms)

    def with_unit_inertias(self) -> Robot:
        """Return a copy whose every moving link has mass 1 [kg] and inertia identity [kg m^2]."""
        unit = pin.Inertia(1.0, np.zeros(3), np.eye(3))
        return self._with_inertias(lambda inertia: unit)

    def scaled(self, mass_scale: float) -> Robot:
        """Return a copy whose masses and inertias are multiplied by `mass_scale`.

        Raises: InputError, NonFiniteError.
        """
        scale = _require_finite("mass_scale", mass_scale)
        if scale <= 0.0:
            raise InputError("mass_scale must be positive", given=mass_scale)
        return self._with_inertias(
            lambda inertia: pin.Inertia(
                scale * inertia.mass, inertia.lever, scale * inertia.inertia
            )
        )

    def with_payload(
        self, frame: str, mass: float, com_in_frame: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> Robot:
        """Return a copy that carries a point mass [kg] at `com_in_frame` [m] of a frame.

        Raises: NameNotFoundError, InputError, NonFiniteError.
        """
        if _require_finite("payload mass", mass) < 0.0:
            raise InputError("A payload's mass must not be negative", given=mass)
        com = np.array([_require_finite("com_in_frame", x) for x in com_in_frame])
        if com.shape != (3,):
            raise InputError("com_in_frame needs three numbers [m]", given=com_in_frame)
        carrier = self.model.frames[self.frame_id(frame)]
        payload = pin.Inertia(float(mass), carrier.placement.act(com), np.zeros((3, 3)))
        model = self.model.copy()
        model.inertias[carrier.parentJoint] = model.inertias[carrier.parentJoint] + payload
        return replace(self, model=model)

    def _with_inertias(self, change: Callable[[pin.Inertia], pin.Inertia]) -> Robot:
        model = self.model.copy()
        for joint in range(1, model.njoints):
            model.inertias[joint] = change(model.inertias[joint])
        return replace(self, model=model)

    @cached_property
    def _frame_ids(self) -> dict[str, int]:
        # A joint and a link may share a name: the link's frame (the later one) is meant.
        return {frame.name: index for index, frame in enumerate(self.model.frames)}


def _by_name(kind: str, name: str, surfaces: Sequence[Surface]) -> Surface:
    for surface in surfaces:
        if surface.name == name:
            return surface
    raise NameNotFoundError(kind, name, [surface.name for surface in surfaces])


def _read_only(values: object) -> np.ndarray:
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


def _require_finite(what: str, value: float) -> float:
    if not np.isfinite(value):
        raise NonFiniteError(f"{what} is not finite", given=value)
    return float(value)


def require_robot(what: str, robot: object) -> None:
    """Refuse what is no robot, say only its name. Raises: `InputError`."""
    require_kind(what, robot, Robot, "Say get_robot('hrp2'), or load_robot('my.urdf')")
