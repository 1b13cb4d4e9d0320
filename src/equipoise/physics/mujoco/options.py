"""What MuJoCo is told beyond robot and world: step, joint losses, friction, softness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.errors import InputError


@dataclass(frozen=True)
class MujocoOptions:
    """Parameters of the simulated hardware and of the integration.

    `substeps` physics steps a control period. `joint_friction` [N m] dry, `joint_damping`
    [N m s/rad] and `armature` [kg m^2] (rotor inertia) act at every actuated joint.
    `sole_friction`, `hand_friction` are Coulomb coefficients. `contact_time` [s] is the time
    constant with which a contact takes back a penetration: smaller is stiffer, and it must be at
    least twice the physics step.
    """

    substeps: int = 4
    joint_friction: float = 0.2
    joint_damping: float = 0.2
    armature: float = 0.05
    sole_friction: float = 0.8
    hand_friction: float = 0.5
    contact_time: float = 0.01
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)

    def __post_init__(self) -> None:
        if self.substeps < 1:
            raise InputError("substeps must be at least 1 a control period", given=self.substeps)
        for name in ("joint_friction", "joint_damping", "armature"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"{name} must be finite and not negative", given=value)
        for name in ("sole_friction", "hand_friction", "contact_time"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"{name} must be finite and positive", given=value)
