"""Torques through the motors of a MuJoCo model, or straight to its joints if it has none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.spatial import Array

JOINT, IN_PARENT = 0, 1  # mjtTrn: what a motor drives is a joint
PLAIN = 0  # mjtGain.mjGAIN_FIXED, mjtBias.mjBIAS_NONE, mjtDyn.mjDYN_NONE


class Motors:
    """The motors of a robot's joints, by their numbers in MuJoCo, or none at all.

    Raises: `InputError` if some joints have no motor, several, or a servo instead of one.
    """

    def __init__(self, robot: Robot, model: Any, joints: Sequence[int]) -> None:
        self._dofs = np.array([model.jnt_dofadr[j] for j in joints])
        by_joint: dict[int, list[int]] = {int(j): [] for j in joints}
        for k in range(model.nu):
            drives = model.actuator_trnid[k, 0]
            if model.actuator_trntype[k] in (JOINT, IN_PARENT) and drives in by_joint:
                by_joint[int(drives)].append(k)
        names = dict(zip(by_joint, robot.joint_names, strict=True))
        servos = [names[j] for j, ks in by_joint.items() for k in ks if not _is_plain(model, k)]
        if servos:
            raise InputError(
                "joints are driven by servos, which ask for positions or speeds, not for torques",
                given=servos,
                remedy="Make the actuators <motor> (in an MjSpec: actuator.set_to_motor()), or "
                "delete them all: torques then go to qfrc_applied",
            )
        counts = {names[j]: len(ks) for j, ks in by_joint.items()}
        wrong = [name for name, count in counts.items() if count != 1]
        self._numbers: Array | None = None
        if any(counts.values()):
            if wrong:
                raise InputError(
                    "joints need one motor each, or none of them has any",
                    given=wrong,
                    remedy='Add <motor joint="..."/> for each of them, or delete all motors',
                )
            self._numbers = np.array([ks[0] for ks in by_joint.values()])
            self._gear = (
                model.actuator_gear[self._numbers, 0] * model.actuator_gainprm[self._numbers, 0]
            )

    def apply(self, data: Any, tau: Array) -> None:
        """Write torques (na,) [N m]."""
        if self._numbers is None:
            data.qfrc_applied[self._dofs] = tau
        else:
            data.ctrl[self._numbers] = tau / self._gear


def _is_plain(model: Any, k: int) -> bool:
    types = model.actuator_gaintype[k], model.actuator_biastype[k], model.actuator_dyntype[k]
    return all(int(one) == PLAIN for one in types)
