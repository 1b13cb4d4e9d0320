"""The force that pushes an object as it is wanted to travel: a profile and what viscosity asks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from equipoise.compiled import compiled, entrance
from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_number
from equipoise.trajectories.base import instant
from equipoise.trajectories.profile import Profile, profile_at
from equipoise.trajectories.scalar import PUSHING, CompiledScalar
from equipoise.trajectories.travel import Travel, travelled

FASTEST = 15.0 / 8.0  # largest speed of a minimum-jerk step, as a multiple of the mean one


@dataclass(frozen=True)
class PushingForce(CompiledScalar):
    """The `profile` [N] plus `viscosity` [N s/m] times the speed of the wanted `travel`."""

    profile: Profile
    viscosity: float
    travel: Travel
    kind = PUSHING

    def __post_init__(self) -> None:
        if not isinstance(self.profile, Profile) or not isinstance(self.travel, Travel):
            raise InputError(
                "a pushing force needs a Profile and a Travel",
                given=(type(self.profile).__name__, type(self.travel).__name__),
            )
        if not real_number("the viscosity of a pushing force", self.viscosity) >= 0.0:
            raise InputError("a viscosity must not be negative [N s/m]", given=self.viscosity)

    @cached_property
    def numbers(self) -> Array:
        """The travel's numbers, the viscosity, and the profile's numbers."""
        return np.concatenate((self.travel.numbers, [self.viscosity], self.profile.numbers))

    @property
    def least(self) -> float:
        """No less than the profile's; a travel backwards takes what viscosity asks for at most."""
        span = self.travel.end - self.travel.start
        backwards = min(self.travel.distance, 0.0) * FASTEST / span
        return self.profile.least + self.viscosity * backwards

    def at(self, t: float) -> float:
        """Return the wanted force [N] at time `t` [s]."""
        return pushing_alone(self.numbers, instant(t))


@compiled
def pushing_at(numbers: np.ndarray, t: float) -> float:
    """Return the force at time t; see `PushingForce.numbers`."""
    _, speed, _ = travelled(numbers, t)
    return profile_at(numbers[4:], t) + numbers[3] * speed


@entrance
def pushing_alone(numbers: np.ndarray, t: float) -> float:
    """Return one pushing force."""
    return pushing_at(numbers, t)
