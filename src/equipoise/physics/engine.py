"""What a physics engine offers to the run loop."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from equipoise.spatial import Array


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
    """Advances a robot in contact by one control period under a held torque."""

    @property
    def state(self) -> PhysicsState:
        """The present state."""

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period with `tau` (na,) [N m] held; return the new state.

        Raises: `equipoise.physics.rigid.engine.DivergedError` if the state is no longer finite.
        """
