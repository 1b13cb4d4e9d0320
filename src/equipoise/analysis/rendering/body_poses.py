"""Where the bodies of a world are at a tick: fixed, held, pushed, or as an engine logged them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from equipoise.collision.scene import Body
from equipoise.kinematics import Kinematics
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import POSE_SIZE, Array


def body_pose(setup: Setup, body: Body, kin: Kinematics, values: Mapping[str, Array]) -> pin.SE3:
    """Return a body's pose in the world, from logged `values` by channel where there are some."""
    logged = values.get(f"object/{body.name}")
    if logged is not None and np.isfinite(logged[:POSE_SIZE]).all():
        return pin.XYZQUATToSE3(logged[:POSE_SIZE])
    joint, T_joint_body = carrier_of(setup, body)
    T = kin.pin_data.oMi[joint] * T_joint_body
    pushed = values.get(f"slider/{body.name}")
    if pushed is not None and np.isfinite(pushed[0]):
        T = pin.SE3(T.rotation, T.translation + pushed[0] * setup.sliders[body.name])
    return T


def carrier_of(setup: Setup, body: Body) -> tuple[int, pin.SE3]:
    """Return the joint that carries a body, and the body's axes in that joint's."""
    if body.frame is None:
        return 0, body.T_parent_body
    frame = setup.robot.model.frames[setup.robot.frame_id(body.frame)]
    return frame.parentJoint, frame.placement * body.T_parent_body
