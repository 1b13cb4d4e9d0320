"""Where a page draws a joint: the poses of its node and of those that it hangs on, together."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.viewer.drawing import Drawing


def in_the_world(drawing: Drawing, joint: int | None) -> np.ndarray:
    """Return the pose (7,) of a joint's node: x, y, z [m] and quaternion xyzw."""
    T = pin.SE3.Identity()
    while joint is not None:
        node = drawing._nodes[joint]
        T = pin.XYZQUATToSE3(np.concatenate([node.position, node.wxyz[[1, 2, 3, 0]]])) * T
        joint = drawing._above[joint]
    return pin.SE3ToXYZQUAT(T)
