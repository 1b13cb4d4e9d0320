"""A stand-in for a robot whose base is fixed to the world, small enough to see through."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.kinematics import Kinematics, kinematics_at
from equipoise.robots.base import FIXED
from equipoise.spatial import pose


class Arm:
    """A stand-in for a robot with a fixed base: two links that swing and one that slides."""

    def __init__(self) -> None:
        model = pin.Model()
        parent, places = 0, (pose((0, 0, 0.5)), pose((0.3, 0, 0)), pose((0.3, 0, 0)))
        kinds = pin.JointModelRZ(), pin.JointModelRY(), pin.JointModelPZ()
        for k, (kind, place) in enumerate(zip(kinds, places, strict=True)):
            parent = model.addJoint(parent, kind, place, f"joint{k}")
            lever = np.array([0.15, 0.0, 0.02])
            model.appendBodyToJoint(
                parent, pin.Inertia(2.0, lever, 0.02 * np.eye(3)), pin.SE3.Identity()
            )
        model.addFrame(pin.Frame("tip", parent, pose((0.1, 0, 0)), pin.FrameType.OP_FRAME))
        self.model, self.name = model, "arm"
        self.nq = self.nv = self.na = 3
        self.nq_base = self.nv_base = 0
        self.soles = self.palms = ()
        self.joint_names = self.velocity_names = tuple(model.names)[1:]
        self.frame_names = tuple(frame.name for frame in model.frames)
        self.q_min, self.q_max = np.array([-2.0, -1.5, -0.3]), np.array([2.0, 1.5, 0.3])
        self.v_max, self.tau_max = np.full(3, 3.0), np.full(3, 80.0)
        self.q_half_sitting = np.array([0.3, 0.4, 0.05])
        self.camera = None
        self.base, self.actuated, self.followers = FIXED, (1, 2, 3), {}

    def frame_id(self, frame: str | int) -> int:
        return self.model.getFrameId(frame) if isinstance(frame, str) else frame

    def at(self, q: np.ndarray, v: np.ndarray | None = None, t: float = 0.0) -> Kinematics:
        return kinematics_at(self, q, v, t)


def arm_in_mujoco(at: str = "0 0 0", turned: str = "1 0 0 0") -> str:
    """Return the same arm as an MJCF, its base at a place, with a ball as tip, and a table."""
    inertial = '<inertial pos="0.15 0 0.02" mass="2" diaginertia="0.02 0.02 0.02"/>'
    return f"""
<mujoco>
  <worldbody>
    <geom name="table" type="box" size="0.2 0.2 0.05" pos="0 0 -10"/>
    <body pos="{at}" quat="{turned}">
      <body pos="0 0 0.5">
        <joint name="joint0" axis="0 0 1"/>{inertial}
        <body pos="0.3 0 0">
          <joint name="joint1" axis="0 1 0"/>{inertial}
          <body pos="0.3 0 0">
            <joint name="joint2" type="slide" axis="0 0 1"/>{inertial}
            <geom type="sphere" size="0.02" pos="0.1 0 0"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"""
