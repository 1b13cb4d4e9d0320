"""Inverse kinematics with strict priorities: two hands that cannot both have their way.

Contacts come first, then balance and joint limits, then the right hand, the left hand, the posture.
One hand is sent forward, the other back, further apart than the robot reaches. The left one gives
way, and nothing above it notices.
"""

from __future__ import annotations

import numpy as np

from equipoise import (
    ContactStack,
    MotionGenerator,
    SoleContact,
    Waypoint,
    WaypointTrajectory,
    get_robot,
    make_solver,
)
from equipoise.contacts import SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.motion import MotionStep
from equipoise.tasks import (
    ComPolygonTask,
    ContactTask,
    FramePoseTask,
    JointLimitsTask,
    PostureTask,
    Task,
)

DT = 0.005


def main(seconds: float = 3.0) -> tuple[MotionStep, dict[str, np.ndarray]]:
    """Follow the hierarchy; print and return the last step and what the hands miss."""
    robot = get_robot("hrp2")
    kin = robot.at(robot.q_half_sitting)
    soles = [SoleContact.standing(sole, kin) for sole in robot.soles]
    corners = [sole_corners(c.sole, c.T_world_anchor) for c in soles]
    polygon = SupportPolygon.of_points(np.vstack(corners))
    hands: list[Task] = []
    for palm, shift in (("right_palm", (0.6, 0.0, 0.1)), ("left_palm", (-0.7, 0.0, 0.1))):
        there = kin.placement(palm)
        there.translation += np.array(shift)
        path = WaypointTrajectory([Waypoint(0.0, kin.placement(palm)), Waypoint(2.0, there)])
        hands.append(FramePoseTask(palm, palm, path))
    balance = ComPolygonTask("balance", polygon, margin=0.03)
    levels: list[list[Task]] = [
        [ContactTask("contacts", ContactStack(soles))],
        [balance, JointLimitsTask("limits", robot)],
        *([hand] for hand in hands),
        [PostureTask("posture", robot, robot.q_half_sitting[robot.nq_base :])],
    ]
    motion = MotionGenerator(robot, levels, make_solver("active_set"), DT, robot.q_half_sitting)
    for k in range(round(seconds / DT) + 1):
        step = motion.step(k * DT)
    solution = step.solution

    print(step.hierarchy)
    print(solution.certificate(step.hierarchy))
    for task in hands:
        off = np.linalg.norm(task.error(step.kin, step.t)[:3])
        print(f"{task.name}: {1000 * off:.1f} mm from its target")
    print(f"balance: {1000 * polygon.margin(step.kin.p_world_com):.1f} mm inside the polygon")
    bound = np.flatnonzero(np.abs(solution.active) == 1).tolist()
    print("at a bound:", ", ".join(step.hierarchy.name_of(row) for row in bound))
    return step, {task.name: task.error(step.kin, step.t) for task in hands}


if __name__ == "__main__":
    main()
