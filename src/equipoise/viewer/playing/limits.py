"""How fast hands and joints may go in a session: slowly enough for a body that must not tip."""

from __future__ import annotations

import numpy as np

from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.viewer.playing.lead import Pace

PACE = Pace(speed=0.25, acceleration=0.5, near=2.5, joints=0.4)
CARRYING, FREE = 1.0, 6.0  # [rad/s^2] of the joints that carry the body, and of all others
SPEEDS = 0.8  # [rad/s] of joints: towards a stretched arm they would race


def speeds_of(robot: Robot) -> dict[str, float]:
    """Return how fast [rad/s] each joint may go, by name."""
    most = np.minimum(robot.v_max, SPEEDS)
    return dict(zip(robot.joint_names, most.tolist(), strict=True))


def accelerations_of(robot: Robot) -> Array:
    """Return how fast joints may speed up (na,): those under the body throw it off its feet."""
    most = np.full(robot.na, FREE)
    for frame in [*(sole.frame for sole in robot.soles), *(foot.frame for foot in robot.feet)]:
        most[list(robot.joints_between(frame))] = CARRYING
    return most
