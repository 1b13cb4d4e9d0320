"""A task of one's own: the palm stays under a ceiling while it is led through it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise import (
    ContactStack,
    Kinematics,
    MotionGenerator,
    Rows,
    SoleContact,
    Waypoint,
    WaypointTrajectory,
    get_robot,
    make_solver,
)
from equipoise.tasks import ContactTask, FramePoseTask, JointLimitsTask, PostureTask, Task


class CeilingTask(Task):
    """Keep the origin of a frame below `height` [m]: `v_z <= rate * (height - z)`."""

    labels = ("z",)
    units = ("m",)

    def __init__(self, name: str, frame: str, height: float, *, rate: float = 10.0) -> None:
        super().__init__(name)
        self.frame, self.height, self.rate = frame, height, rate

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return one upper-bounded row."""
        A = kin.jacobian(self.frame)[2:3]
        upper = np.array([self.rate * (self.height - kin.placement(self.frame).translation[2])])
        return Rows(self.name, "m/s", self.labels, A, np.array([-np.inf]), upper)

    def error(self, kin: Kinematics, t: float) -> np.ndarray:
        """Return how far [m] the frame is above the ceiling."""
        return np.maximum(0.0, kin.placement(self.frame).translation[2:3] - self.height)


def main(dt: float = 0.005) -> tuple[float, float, float]:
    """Lead the hand 10 cm through the ceiling; return how high it came, ceiling, target [m]."""
    robot = get_robot("hrp2")
    kin = robot.at(robot.q_half_sitting)
    soles = [SoleContact.standing(sole, kin) for sole in robot.soles]
    palm = "left_palm"
    here = kin.placement(palm)
    there = pin.SE3(here.rotation, here.translation + np.array([0.1, 0.0, 0.3]))
    ceiling = CeilingTask("ceiling", palm, here.translation[2] + 0.2)
    path = WaypointTrajectory([Waypoint(0.0, here), Waypoint(1.0, there), Waypoint(2.0, here)])
    levels: list[list[Task]] = [
        [ContactTask("contacts", ContactStack(soles))],
        [ceiling, JointLimitsTask("limits", robot)],
        [FramePoseTask("hand", palm, path)],
        [PostureTask("posture", robot, robot.q_half_sitting[robot.nq_base :])],
    ]
    motion = MotionGenerator(robot, levels, make_solver("active_set"), dt, robot.q_half_sitting)
    steps = [motion.step(k * dt) for k in range(round(2.5 / dt))]
    top = max(robot.at(s.q_ref).placement(palm).translation[2] for s in steps)
    print(
        f"ceiling {ceiling.height:.4f} m, target {there.translation[2]:.4f} m, came to {top:.4f} m"
    )
    return top, ceiling.height, there.translation[2]


if __name__ == "__main__":
    main()
