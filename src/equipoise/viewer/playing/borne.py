"""What hands bear: the force with which the motors of an arm lift more than the arm itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.robots import Robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array

LEAST_SINGULAR = 0.05  # [m], relative to the largest: directions in which a stretched arm is stiff


class HandForces:
    """Tells from torques what each hand lifts, for a plot: the law knows nothing of it.

    Joints that move one hand only are asked, with the nominal weights of the robot. What moving
    takes counts as lifted.
    """

    def __init__(self, robot: Robot, hands: Sequence[str]) -> None:
        self._robot, self._dynamics = robot, JointDynamics(robot.model)
        moving = {hand: set(robot.joints_between(hand)) for hand in hands}
        feet = [*(sole.frame for sole in robot.soles), *(foot.frame for foot in robot.feet)]
        legs = {joint for foot in feet for joint in robot.joints_between(foot)}
        self._arms: dict[str, list[int]] = {}
        for hand, joints in moving.items():
            others = {j for other, more in moving.items() if other != hand for j in more}
            arm = sorted(joints - others - legs)
            if len(arm) >= 3:
                self._arms[hand] = arm

    @property
    def hands(self) -> tuple[str, ...]:
        """The hands on arms of their own."""
        return tuple(self._arms)

    def lifted(self, q: Array, tau: Array) -> dict[str, float]:
        """Return by hand what it lifts [N], at `q` (nq,) under torques `tau` (na,)."""
        if not self._arms:
            return {}
        base, kin = self._robot.nv_base, self._robot.at(q)
        more = tau - self._dynamics.gravity(q)[base:]
        found = {}
        for hand, arm in self._arms.items():
            J = kin.jacobian(hand)[:3, base:][:, arm]
            force = np.linalg.lstsq(J.T, more[arm], rcond=LEAST_SINGULAR)[0]
            found[hand] = float(force[2])
        return found
