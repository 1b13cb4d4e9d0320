"""What the two doors of the whole controller put together: contacts, levels, gains, bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from equipoise.contacts import Contact, ContactStack
from equipoise.control import (
    ControlGains,
    Projector,
    ReactionBounds,
    SignFunction,
    advise_for_postures,
    advise_for_soft_floor,
    advise_gains,
)
from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.given import mapping_of
from equipoise.motion.levels import (
    Accelerations,
    Wishes,
    bound_accelerations,
    feet_of,
    usual_levels,
)
from equipoise.motion.reaching import wait_where_out_of_reach
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_array, real_number, real_vector, require_period
from equipoise.tasks import Task
from equipoise.trajectories import LiveScalar
from equipoise.trajectories.scalars import Scalar
from equipoise.wbc.settings import ControlSettings

Wanted = float | Scalar
Forces = Mapping[str, Wanted | Sequence[Wanted]]
Shape = Literal["start", "postures"]

RIGID_ALPHA, RIGID_LAYER = 20.0, 0.05  # [1/s], [rad/s] where the contacts do not give
FORCE_LAYER = 0.5  # [N] of sgn_F
K_IP = 5.0


@dataclass(frozen=True)
class LoopSettings:
    """What a loop is like, as far as gains and bounds depend on it.

    `period` [s] between two ticks. `delay` [s] between measurement and torque that has to be
    survived on contacts that give: the adviser makes the gains so slow that they bear three times
    as much; 0 means rigid contacts. `rotor_inertia` [kg m^2] of the joints behind their gears, one
    or (na,): where it is not small, the gains need it. `friction` of the feet; `margin` [m] that
    the centre of mass keeps to the edge of the feet; `observer` [s], how slowly the measured
    reaction is followed. `accelerations` [rad/s^2] bound the joints of the reference, so that they
    stop in time: one number, (na,), or some by name; None bounds nothing. `shape` of the gain:
    that of the inertia matrix at the start, or of its mean over `postures`, which is weaker at the
    start and stable with stretched arms too.
    Raises: `InputError`.
    """

    period: float = 0.001
    delay: float = 0.003
    rotor_inertia: float | Array = 0.0
    friction: float = 0.7
    margin: float = 0.02
    observer: float = 0.02
    accelerations: Accelerations | None = None
    shape: Shape = "start"

    def __post_init__(self) -> None:
        require_period(self.period)
        for name in ("delay", "margin", "observer"):
            if not real_number(f"the {name} of a loop", getattr(self, name)) >= 0.0:
                raise InputError(
                    f"the {name} of a loop must not be negative", given=getattr(self, name)
                )
        inertia = real_array("the rotor inertia of a loop", self.rotor_inertia, None)
        if (inertia < 0.0).any():
            raise InputError("a rotor inertia must not be negative", given=inertia.tolist())
        if self.shape not in get_args(Shape):
            raise InputError(
                "unknown shape of the gain", given=self.shape, known=list(get_args(Shape))
            )


@dataclass(frozen=True)
class Opened:
    """What `WholeBodyController` is made of."""

    levels: list[list[Task]]
    contacts: ContactStack
    settings: ControlSettings
    q_start: Array
    wanted_forces: dict[str, list[Scalar]]


@dataclass(frozen=True)
class Wish:
    """What a robot is to do: tasks by priority, contacts beside the feet, forces by contact."""

    tasks: Wishes
    contacts: Sequence[Contact]
    forces: Forces | None


def stand(
    robot: Robot, q: Array | None, feet: Sequence[str] | None, wish: Wish, loop: LoopSettings
) -> Opened:
    """Return a controller's parts for a robot that stands on soles or points.

    Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
    """
    require_robot("the robot that stands", robot)
    if not robot.nv_base:
        raise InputError(
            f"robot {robot.name} is fixed to the world: it stands on nothing",
            remedy="Use `WholeBodyController.fixed(robot, ...)`",
        )
    q = _start(robot, q)
    return _open(robot, q, feet_of(robot, q, feet, loop.friction), wish, loop)


def mount(robot: Robot, q: Array | None, wish: Wish, loop: LoopSettings) -> Opened:
    """Return a controller's parts for a robot whose base is fixed to the world.

    Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
    """
    require_robot("the robot that is fixed", robot)
    if robot.nv_base:
        raise InputError(
            f"the base of robot {robot.name} moves: something has to carry it",
            remedy="Use `WholeBodyController.standing(robot, ...)`, or load it with a fixed base",
        )
    return _open(robot, _start(robot, q), (), wish, loop)


def _start(robot: Robot, q: Array | None) -> Array:
    return robot.q_half_sitting if q is None else real_vector("q_start", q, robot.nq)


def _open(
    robot: Robot, q: Array, feet: Sequence[Contact], wish: Wish, loop: LoopSettings
) -> Opened:
    stack = ContactStack([*feet, *wish.contacts])
    settings = ControlSettings(
        gains_for(robot, stack, q, loop),
        loop.period,
        bounds=ReactionBounds() if robot.nv_base else None,
        filter_time=loop.observer,
    )
    levels = usual_levels(robot, q, stack.contacts, wish.tasks, loop.margin)
    wait_where_out_of_reach(robot, levels, q, loop.period)
    if loop.accelerations is not None:
        levels = bound_accelerations(robot, levels, loop.accelerations, loop.period)
    return Opened(levels, stack, settings, q, _wanted(stack, wish.forces))


def gains_for(robot: Robot, contacts: ContactStack, q: Array, loop: LoopSettings) -> ControlGains:
    """Return the adviser's gains for a loop, at the posture `q` (nq,)."""
    if np.ndim(loop.rotor_inertia) and np.shape(loop.rotor_inertia) != (robot.na,):
        raise ShapeError("the rotor inertia of a loop", np.shape(loop.rotor_inertia), (robot.na,))
    alpha, layer, kappa = RIGID_ALPHA, RIGID_LAYER, None
    projector: Projector = "euclidean"
    if loop.delay > 0.0:
        projector = "damping"
        soft = advise_for_soft_floor(loop.delay, loop.period, K_IP, projector=projector)
        alpha, layer, kappa = soft.alpha, soft.layer, soft.kappa
    look = advise_for_postures if loop.shape == "postures" else advise_gains
    advice = look(
        robot, contacts, q, loop.period,
        alpha=alpha, kappa=kappa, rotor_inertia=loop.rotor_inertia,
    )  # fmt: skip
    return ControlGains(
        K_d=advice.K_d,
        alpha=alpha,
        k_ip=K_IP,
        sgn_p=SignFunction("saturation", layer),
        sgn_F=SignFunction("saturation", FORCE_LAYER),
        damp_violation=loop.delay > 0.0,
        projector=projector,
    )


def _wanted(stack: ContactStack, forces: Forces | None) -> dict[str, list[Scalar]]:
    """Return a scalar for each regulated row; a number becomes one that can be changed."""
    forces = mapping_of("the wanted forces", forces)
    for name in forces:
        if name not in stack.rows:
            raise NameNotFoundError("contact", name, stack.rows)
    wanted: dict[str, list[Scalar]] = {}
    for contact in stack.contacts:
        given = forces.get(contact.name, [0.0] * len(contact.regulated))
        several = given if isinstance(given, Sequence) else [given]
        if several:
            wanted[contact.name] = [_scalar(one) for one in several]
    return wanted


def _scalar(one: Wanted) -> Scalar:
    return LiveScalar(one, start=0.0) if isinstance(one, int | float) else one
