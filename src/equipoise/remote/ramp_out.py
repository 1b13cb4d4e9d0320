"""The end of a run that somebody asked for: the robot is brought to rest before it is let go."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from equipoise.simulation.operator import StopRequested
from equipoise.spatial import Array
from equipoise.wbc import WholeBodyController

SLOWING = 0.6  # [s] in which the clock of what is wanted comes to a stand
SHORTEST, LONGEST = 0.9, 2.0  # [s] of ramping out
STEPPING = 6.0  # [s] that feet are waited for
AT_REST = 0.05  # [rad/s] of every joint

Rest = Callable[[], bool]


class RampOut:
    """Lets all that is wanted come to a stand once somebody asks, and ends the run at rest.

    `asked` says in words who asks for the end, empty if nobody does; `stands` is asked from then on
    whether the robot stands, and lets it come to that (a walk puts its feet side by side). The law
    runs to the end; the robot's own servos then take over a robot that stands still, around the
    torque of that moment.
    """

    def __init__(self, controller: WholeBodyController, stands: Rest | None = None) -> None:
        self._controller, self._stands = controller, stands or _at_once
        self.asked: Callable[[], str] = _nobody
        self.told = ""
        self._asked_at: float | None = None
        self._since: float | None = None
        self._ticked = False

    def ask(self, cause: str) -> None:
        """Ask for the end from now on."""
        self.asked = lambda: cause

    def before_tick(self, t: float, v: Array) -> None:
        """Go on with the end, at time `t` [s] and velocity `v` (nv,).

        Raises: `StopRequested` once the robot is at rest, after 2 s, or if it was never driven.
        """
        first, self._ticked = not self._ticked, True
        if self._since is None:
            cause = self.asked()
            if not cause:
                return
            if first:
                raise StopRequested
            if self._asked_at is None:
                self._asked_at, self.told = t, f"t = {t:.3f} s: ramped out: {cause}"
            if not self._stands() and t - self._asked_at < STEPPING:
                return
            self._since = t
            self._controller.come_to_stand(t, SLOWING)
        rates = np.abs(v[self._controller.robot.nv_base :])
        still = float(rates.max(initial=0.0)) < AT_REST
        if t - self._since >= (SHORTEST if still else LONGEST):
            raise StopRequested


def _at_once() -> bool:
    return True


def _nobody() -> str:
    return ""
