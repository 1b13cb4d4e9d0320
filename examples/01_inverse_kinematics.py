"""Inverse kinematics with strict priorities: two hands that cannot both have their way.

Contacts come first, then balance and joint limits, then the right hand, the left hand, the posture.
One hand is sent forward, the other back, further apart than the robot reaches. The left one gives
way, and nothing above it notices.
"""

from __future__ import annotations

import numpy as np

from equipoise import get_robot
from equipoise.contacts import ContactStack, SoleContact, SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.hqp import make_solver
from equipoise.kinematics import KinematicsEvaluator
from equipoise.motion import MotionGenerator, MotionStep
from equipoise.tasks import (
    ComPolygonTask,
    ContactTask,
    FramePoseTask,
    JointLimitsTask,
    PostureTask,
    Waypoint,
    WaypointTrajectory,
)

DT = 0.005


def main(seconds: float = 3.0) -> tuple[MotionStep, dict[str, np.ndarray]]:
    """Follow the hierarchy; print and return the last step and what the hands miss."""
    robot = get_robot("hrp2")
    kin = KinematicsEvaluator(robot).at(robot.q_half_sitting, np.zeros(robot.nv))
    place = {name: kin.placement(robot.frame_id(name)) for name in robot.frame_names}
    soles = [SoleContact.standing(sole, kin) for sole in robot.soles]
    corners = [sole_corners(c.sole, c.T_world_anchor) for c in soles]
    polygon = SupportPolygon.of_points(np.vstack(corners))
    hands = []
    for palm, shift in (("right_palm", (0.6, 0.0, 0.1)), ("left_palm", (-0.7, 0.0, 0.1))):
        there = place[palm].copy()
        there.translation += np.array(shift)
        way = WaypointTrajectory([Waypoint(0.0, place[palm]), Waypoint(2.0, there)])
        hands.append(FramePoseTask(palm, robot.frame_id(palm), way))
    balance = ComPolygonTask("balance", polygon, margin=0.03)
    levels = [
        [ContactTask("contacts", ContactStack(soles))],
        [balance, JointLimitsTask("limits", robot)],
        *([hand] for hand in hands),
        [PostureTask("posture", robot, robot.q_half_sitting[7:])],
    ]
    motion = MotionGenerator(robot, levels, make_solver("active_set"), DT, robot.q_half_sitting)
    for k in range(round(seconds / DT) + 1):
        step = motion.step(k * DT)

    print(step.hierarchy)
    print(step.solution.certificate(step.hierarchy))
    for task in hands:
        off = np.linalg.norm(task.error(step.kin, step.t)[:3])
        print(f"{task.name}: {1000 * off:.1f} mm from its target")
    print(f"balance: {1000 * polygon.margin(step.kin.p_world_com):.1f} mm inside the polygon")
    bound = [step.hierarchy.name_of(r) for r in np.flatnonzero(np.abs(step.solution.active) == 1)]
    print("at a bound:", ", ".join(bound))
    return step, {task.name: task.error(step.kin, step.t) for task in hands}


if __name__ == "__main__":
    main()
