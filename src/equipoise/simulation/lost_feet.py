"""A foot of a walk that lost its ground: the other one carries, or the robot is made safe."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from equipoise.robots import Robot
from equipoise.simulation.sensors import Reading
from equipoise.walking import Walker
from equipoise.walking.events import NAMES

LOADED = 0.1  # of the weight, by plan: from there on a foot without load is missed
AWAY = 0.005  # [m] from where it stood, as is one that is no longer there
SURE = 0.012  # [s] without load, after which a foot has lost its ground
PATIENCE = 0.15  # [s] after which nobody waits any longer for a foot that does not come back


class LostFeet:
    """Looks after feet that are believed to carry and do not: `update` once a tick.

    One that is where it stood, or will be lifted soon, and is not to have a `LOADED` share of the
    weight, is only light. After `SURE` the walker is asked to stand on the other foot, once. Where
    it cannot, the foot may still come down; is it not there after `PATIENCE`, and the divergent
    component of the nominal centre of mass outside of what is left to stand on, then nothing holds
    the robot.
    """

    def __init__(self, walker: Walker, robot: Robot, contacts: Sequence[str]) -> None:
        self._walker, self._robot, self._contacts = walker, robot, contacts
        self._since: list[float | None] = [None, None]
        self._asked = [False, False]

    def update(self, t: float, missing: Collection[str], reading: Reading) -> str:
        """Look at time `t` [s]; return why the robot had better be made safe, else nothing.

        `missing` are the contacts that are planned to carry and do not.
        """
        for foot, name in enumerate(self._contacts):
            gone = name in missing and foot in self._walker.supports
            if not gone or not self._is_missed(foot, reading):
                self._since[foot], self._asked[foot] = None, False
                continue
            since = self._since[foot]
            if since is None:
                since = self._since[foot] = t
            if t - since >= SURE and not self._asked[foot]:
                self._asked[foot] = True
                self._walker.lose(t, foot)
            elif t - since >= PATIENCE and not self._is_held(missing, reading):
                return f"the {NAMES[foot]} foot has lost its ground, and nothing else holds it"
        return ""

    def _is_missed(self, foot: int, reading: Reading) -> bool:
        """Return whether a foot without load is away from where it stood, or ought to carry."""
        walker, feet = self._walker, self._walker.planner.feet
        if walker.supports == (foot,):
            return True
        if np.isfinite(reading.q).all() and not walker.lifts_soon(foot):
            place = self._robot.at(reading.q).placement(feet.soles[foot].frame).translation
            if np.linalg.norm(place - walker.stance[foot].translation) > AWAY:
                return True
        here, other = (feet.centre(k, walker.stance[k])[:2] for k in (foot, 1 - foot))
        way = here - other
        zmp = walker.plan.centre.at(walker.clock.t).zmp
        return bool((zmp - other) @ way > LOADED * (way @ way))

    def there(self, missing: Collection[str]) -> tuple[int, ...]:
        """Return the feet that are believed to carry, and do."""
        return tuple(
            foot for foot in self._walker.supports
            if self._contacts[foot] not in missing
        )  # fmt: skip

    def _is_held(self, missing: Collection[str], reading: Reading) -> bool:
        """Return whether the divergent component is over the feet that are there."""
        standing = self.there(missing)
        if not standing or not np.isfinite(reading.q).all() or not np.isfinite(reading.v).all():
            return not standing
        walker = self._walker
        kin = self._robot.at(reading.q)
        omega = walker.planner.settings.omega
        dcm = kin.p_world_com[:2] + (kin.J_com @ reading.v)[:2] / omega
        return walker.planner.feet.support(walker.stance, standing).margin(dcm) >= 0.0
