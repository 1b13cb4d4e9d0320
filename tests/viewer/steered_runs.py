"""Short simulations of the tray that a script steers."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from unittest.mock import patch

import numpy as np

from equipoise.scenarios import read_scenario
from equipoise.simulation.build import assemble
from equipoise.simulation.operator import OperatorRequest, StopRequested
from equipoise.simulation.simulation import Simulation


@cache
def start() -> np.ndarray:
    """Return the posture the tray starts from, found once."""
    return Simulation(read_scenario("tray", ["duration=0.001"])).assembly.q_start


def simulation(duration: float) -> Simulation:
    """Return a fresh simulation of the tray."""
    q_start = start()
    with patch.object(assemble, "starting_posture", lambda *of: q_start.copy()):
        return Simulation(read_scenario("tray", [f"duration={duration}"]))


class Script:
    """Steers by a list: request by tick; `stop` is the tick that is no longer run."""

    def __init__(self, request: Mapping[int, OperatorRequest], stop: int | None = None) -> None:
        self.paused_s = 0.0
        self.seen: list[float] = []
        self._requests, self._stop = dict(request), stop

    def before_tick(self, t: float) -> OperatorRequest | None:
        """Return what the script says."""
        if self._stop is not None and len(self.seen) >= self._stop:
            raise StopRequested
        return self._requests.get(len(self.seen))

    def after_tick(self, t: float, values: Mapping[str, np.ndarray]) -> None:
        """Remember the time."""
        self.seen.append(t)
