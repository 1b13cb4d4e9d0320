"""A grasp: two frames of the robot hold one rigid massless object, six rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.contacts.base import WRENCH_LABELS, WRENCH_UNITS, Contact
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array, skew


@dataclass(frozen=True, kw_only=True)
class GraspContact(Contact):
    """The pose of frame b relative to frame a stays at `T_a_b`.

    Rows and wrench are written in the axes of a, at the origin of b: `lam` is the wrench the
    object exerts on the body of b (and its opposite on the body of a). With the z axis of a
    pointing to b, `lam[2] >= 0` is a squeeze of the object.
    """

    frame_a: int
    frame_b: int
    T_a_b: pin.SE3

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""
        return WRENCH_LABELS

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""
        return WRENCH_UNITS

    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J` (6, nv): twist of b as seen from a."""
        R_a, lever = self._axes_and_lever(kin)
        turn_b = np.zeros((6, 6))
        turn_b[:3, :3] = turn_b[3:, 3:] = R_a.T
        turn_a = -turn_b
        turn_a[:3, 3:] = R_a.T @ skew(lever)
        return turn_a @ kin.jacobian(self.frame_a) + turn_b @ kin.jacobian(self.frame_b)

    def drift(self, kin: Kinematics) -> Array:
        """Return `dJ/dt v` (6,): the relative acceleration at zero `dv/dt`, seen from turning a."""
        twist_a, twist_b = kin.twist(self.frame_a), kin.twist(self.frame_b)
        bias_a, bias_b = kin.drift(self.frame_a), kin.drift(self.frame_b)
        R_a, lever = self._axes_and_lever(kin)
        omega_a = twist_a[3:]
        difference = twist_b - twist_a
        turning = skew(omega_a)
        seen = difference[:3] - turning @ lever
        linear = bias_b[:3] - bias_a[:3] + skew(lever) @ bias_a[3:]
        linear -= turning @ (difference[:3] + seen)
        angular = bias_b[3:] - bias_a[3:] - turning @ difference[3:]
        return np.concatenate((R_a.T @ linear, R_a.T @ angular))

    def residual(self, kin: Kinematics) -> Array:
        """Return `phi` (6,): shift [m] and rotation vector [rad] of b from its place in a."""
        T_a_b = kin.placement(self.frame_a).actInv(kin.placement(self.frame_b))
        phi = np.empty(6)
        phi[:3] = T_a_b.translation - self.T_a_b.translation
        phi[3:] = pin.log3(T_a_b.rotation @ self.T_a_b.rotation.T)
        return phi

    def _axes_and_lever(self, kin: Kinematics) -> tuple[Array, Array]:
        T_world_a, T_world_b = kin.placement(self.frame_a), kin.placement(self.frame_b)
        return T_world_a.rotation, T_world_b.translation - T_world_a.translation
