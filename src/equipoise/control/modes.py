"""What a supervisor says: its modes, when it leaves them, and which sensors are lost, in words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.control.interface import Measurement
from equipoise.errors import InputError
from equipoise.robots import Robot


class Mode(Enum):
    """What the supervisor lets the robot do; the value is a sentence."""

    RUN = "the law runs on complete measurements"
    DEGRADED = "the law runs on a substitute, or on its way back to the reference"
    SAFE = "the posture is held by a slow law, or the robot sinks, damped"
    STOPPED = "the torque is zero"


@dataclass(frozen=True)
class SupervisorLimits:
    """When a mode is left, and what is done in SAFE.

    `patience` [s]: how long a lost position or velocity may be bridged. A lost contact force is
    bridged for ever. `posture_error` [rad or m], `tilt` [rad] of the base and `overspeed`, a share
    of each joint's speed limit, beyond which the law is switched off. `recovery` [s]: a signal that
    comes back within it brings the law back, over a `ramp` [s]. `delay` [s] from sensors to torques
    that SAFE has to bear. `hold_error` [rad or m] and `hold_tilt` [rad] from the held posture
    beyond which holding is given up. `sinking` [s]: how long the weight is let down before the
    torque may stop.
    """

    patience: float = 0.02
    posture_error: float = 0.8
    tilt: float = 0.9
    overspeed: float = 1.5
    recovery: float = 1.0
    ramp: float = 1.0
    delay: float = 0.005
    hold_error: float = 0.8
    hold_tilt: float = 0.3
    sinking: float = 2.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"limit {name} must be finite and not negative", given=value)


@dataclass(frozen=True)
class ModeChange:
    """At time `t` [s] the mode became `mode` because of `cause`."""

    t: float
    mode: Mode
    cause: str

    def __str__(self) -> str:
        return f"t = {self.t:.3f} s: mode {self.mode.name.lower()}: {self.cause}"


def lost_sensors(robot: Robot, contacts: ContactStack, measured: Measurement) -> str:
    """Return which sensors are lost, in words."""
    lost = []
    q_base, v_base = robot.nq_base, robot.nv_base
    if not np.isfinite([*measured.q[:q_base], *measured.v[:v_base]]).all():
        lost.append("the base")
    missing = ~(np.isfinite(measured.q[q_base:]) & np.isfinite(measured.v[v_base:]))
    if missing.all():
        lost.append("all joints")
    else:
        lost += [name for name, gone in zip(robot.joint_names, missing, strict=True) if gone]
    for name, rows in contacts.rows.items():
        if not np.isfinite(measured.lam[rows]).all():
            lost.append(f"the force of {name}")
    return f"no measurement of {', '.join(lost)}"
