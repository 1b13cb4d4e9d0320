"""What a physics engine offers to the run loop: everything that the loop asks of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np
import pinocchio as pin

from equipoise.errors import EquipoiseError
from equipoise.physics.pushed_object import PushedObject, PushedObjectState
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector


def checked_torque(tau: object, na: int) -> Array:
    """Return joint torques (na,), checked before anything moves.

    Raises: `InputError` for what are no numbers, `ShapeError`, `NonFiniteError`.
    """
    plain = tau if isinstance(tau, np.ndarray) and tau.dtype == np.float64 else None
    if plain is not None and plain.shape == (na,) and np.isfinite(plain).all():
        return plain
    return real_vector("tau", tau, na)


class DivergedError(EquipoiseError):
    """The simulated state is no longer finite."""


class PhysicsState(NamedTuple):
    """State at time `t` [s]: `q` (nq,), `v` (nv,) and the contact multipliers of the step before.

    `lam` (r,) is the mean over the last control period, world on robot; `violation` [m or rad] is
    the largest one of a contact.
    """

    t: float
    q: Array
    v: Array
    lam: Array
    violation: float


class PhysicsEngine(Protocol):
    """Advances a robot in contact by one control period under a held torque.

    `external` (nv,) is the generalised force of whoever pushes, in base axes; it is held in every
    `step` until another is set. `sliders` says of each pushed object how far it has gone;
    `object_names` are the bodies that move freely and can be asked for, none where an engine has
    no such bodies.
    """

    external: Array

    @property
    def sliders(self) -> Mapping[PushedObject, PushedObjectState]:
        """How far each pushed object has gone, and what its contact does."""

    def support(self, name: str, T_world_anchor: pin.SE3 | None) -> None:
        """Let the rows of a sole's contact be those of another place from now on; None: of none.

        What is measured is then in the axes of that place, and a foot in the air violates nothing.
        Raises: `NameNotFoundError`; `InputError` for an engine whose feet cannot leave the floor.
        """

    def remove(self, name: str) -> None:
        """Take a fixed body of the world away.

        Raises: `NameNotFoundError`; `InputError` for an engine whose feet stand on none.
        """

    @property
    def object_names(self) -> tuple[str, ...]:
        """Names of the loose objects."""

    @property
    def state(self) -> PhysicsState:
        """The present state."""

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period with `tau` (na,) [N m] held; return the new state.

        Raises: `DivergedError` if the state is no longer finite.
        """

    def stand(self) -> Array:
        """Let the robot stand at rest where it is; return the torque (na,) [N m] for it.

        The reaction that carries it is then what is measured before the first step.
        """

    def object_pose(self, name: str) -> pin.SE3:
        """Return where a loose object is in the world. Raises: `NameNotFoundError`."""

    def object_twist(self, name: str) -> Array:
        """Return linear [m/s] and angular velocity [rad/s] (6,) of a loose object, world axes.

        Raises: `NameNotFoundError`.
        """
