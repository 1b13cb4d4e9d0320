"""Notices what MuJoCo would only mention: warnings, resets, numbers that are not finite."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from equipoise.physics.engine import DivergedError

CLOCK_ERROR = 1e-6  # [s]
_SENTENCES = {
    "mjWARN_INERTIA": "the inertia matrix became singular",
    "mjWARN_CONTACTFULL": "there was no room for more contacts",
    "mjWARN_CNSTRFULL": "there was no room for more constraints",
    "mjWARN_BADQPOS": "a position became infinite or undefined",
    "mjWARN_BADQVEL": "a velocity became infinite or undefined",
    "mjWARN_BADQACC": "an acceleration became infinite or undefined",
    "mjWARN_BADCTRL": "a control value became infinite or undefined",
}


class EngineWarningError(DivergedError):
    """MuJoCo warned: what it would compute from here on is not to be trusted."""


def silence_log_file(mujoco: ModuleType) -> None:
    """Keep MuJoCo from writing a log file into the present folder; we read its counters."""
    if hasattr(mujoco, "MjLogConfig"):
        config = mujoco.MjLogConfig.get()
        config.logto_file = False
        config.logto_console = False
        config.set()
    else:
        mujoco.set_mju_user_warning(lambda message: None)


class HealthCheck:
    """Says what is wrong; `t` [s] is the engine's own time, so that a reset is noticed."""

    def __init__(self, mujoco: ModuleType, simulated: Any) -> None:
        self._simulated = simulated
        self._kinds = {
            int(getattr(mujoco.mjtWarning, name)): sentence for name, sentence in _SENTENCES.items()
        }

    def require(self, t: float, *, fine: bool) -> None:
        """Raise if MuJoCo warned, lost a number or went back in time in the step before `t` [s].

        `fine` says that there are neither warnings nor lost numbers, so that only the clock is
        looked at. Raises: `EngineWarningError`.
        """
        simulated = self._simulated
        if fine and abs(simulated.time - t) <= CLOCK_ERROR:
            return
        for kind, sentence in self._kinds.items():
            if simulated.warning[kind].number:
                raise EngineWarningError(
                    f"MuJoCo warned at t = {t:.3f} s: {sentence}; lower K_d or the physics step"
                )
        if not (np.isfinite(simulated.qpos).all() and np.isfinite(simulated.qvel).all()):
            raise EngineWarningError(f"the simulation diverged at t = {t:.3f} s")
        if abs(simulated.time - t) > CLOCK_ERROR:
            raise EngineWarningError(
                f"MuJoCo's clock shows {simulated.time:.4f} s at t = {t:.4f} s: it reset itself"
            )
