"""Which motor of a message drives which joint, and the gains of its servo.

Source: the low-level example for the G1 of Unitree's public Python SDK (BSD-3-Clause).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.wire.unitree.layout import MOTORS

_LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
_ARM = (
    *("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow"),
    *("wrist_roll", "wrist_pitch", "wrist_yaw"),
)
G1 = (
    *(f"left_{joint}_joint" for joint in _LEG),
    *(f"right_{joint}_joint" for joint in _LEG),
    *(f"waist_{axis}_joint" for axis in ("yaw", "roll", "pitch")),
    *(f"left_{joint}_joint" for joint in _ARM),
    *(f"right_{joint}_joint" for joint in _ARM),
)
STIFF, SOFT = 100.0, 40.0  # [N m/rad] of a knee, of what is far out


@dataclass(frozen=True)
class Motors:
    """Motors of a robot: `places` (na,) of its joints in a message, gains of their servos (na,).

    `kp` [N m/rad], `kd` [N m s/rad].
    """

    places: Array
    kp: Array
    kd: Array

    @classmethod
    def of(cls, robot: Robot) -> Motors:
        """Return the motors of a robot. Raises: `InputError` for one whose order is not known."""
        strangers = [name for name in robot.joint_names if name not in G1]
        if strangers:
            raise InputError(
                f"the order of the motors of {robot.name} is not known",
                given=strangers,
                known=G1,
                remedy="The unitree wire knows the G1 of 29 joints",
            )
        return cls(
            np.array([G1.index(name) for name in robot.joint_names]),
            np.array([_kp(name) for name in robot.joint_names]),
            np.array([2.0 if "knee" in name else 1.0 for name in robot.joint_names]),
        )


def _kp(name: str) -> float:
    if "knee" in name:
        return STIFF
    return 60.0 if "hip" in name or name == "waist_yaw_joint" else SOFT


assert len(G1) <= MOTORS
