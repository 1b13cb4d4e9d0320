"""Kinematics of one robot at one state: evaluated once a tick, read-only afterwards.

Nothing here reads a mass or an inertia except the centre of mass, which is only offered when it
is asked for: a controller that never asks is free of the dynamic model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.errors import EquipoiseError, NonFiniteError, ShapeError
from equipoise.kinematics.kernels import (
    frame_motion,
    frame_rows,
    take_state,
)
from equipoise.kinematics.live_views import motion_rows, pose_rows
from equipoise.robots import Robot
from equipoise.spatial import Array


class StaleKinematicsError(EquipoiseError):
    """A `Kinematics` was read after its evaluator had moved on to another state."""


@dataclass(frozen=True, slots=True)
class LiveArrays:
    """What kernels read of one robot's kinematics; everything but the last three changes with it.

    `q` (nq,) the configuration; `frames` (nframes, 12) and `joints` (njoints, 12) pose rows;
    `columns` (nv, 6) the world Jacobian transposed; `velocities`, `accelerations` (njoints, 6) of
    joints in their own axes;
    `com` (3,) and `com_rows` (3, nv) the centre of mass; `carries` (njoints, nv) is 1 where a
    velocity moves the body of a joint; `joint_ids` and `joint_of` each frame's joint.
    """

    q: Array
    frames: Array
    joints: Array
    columns: Array
    velocities: Array
    accelerations: Array
    com: Array
    com_rows: Array
    carries: Array
    joint_ids: Array
    joint_of: tuple[int, ...]


class KinematicsEvaluator:
    """Computes `Kinematics`, reusing the buffers of one robot.

    Only the newest `Kinematics` of an evaluator may be read; an older one raises
    `StaleKinematicsError` instead of answering for the wrong state.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.pin_data = robot.model.createData()
        self.stamp = 0
        self.live = _live_arrays(robot, self.pin_data)
        self._no_acceleration = np.zeros(robot.nv)

    def compute(self, q: Array) -> None:
        """Let Pinocchio fill its buffers at `q` (nq,)."""
        model, data = self.robot.model, self.pin_data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)

    def compute_drift(self, q: Array, v: Array) -> None:
        """Let Pinocchio fill its velocities, and its accelerations at zero dv/dt."""
        pin.forwardKinematics(self.robot.model, self.pin_data, q, v, self._no_acceleration)

    def __deepcopy__(self, memo: object) -> KinematicsEvaluator:
        return KinematicsEvaluator(self.robot)  # what looks into a buffer cannot be copied with it

    def at(self, q: Array, v: Array, t: float = 0.0) -> Kinematics:
        """Evaluate the kinematics at configuration `q` (nq,) and velocity `v` (nv,).

        The time `t` [s] matters only to contacts that move by themselves.

        Raises: `ShapeError`; `NonFiniteError` if the state holds a NaN or an infinity.
        """
        robot = self.robot
        if q.shape != (robot.nq,):
            raise ShapeError("q", q.shape, (robot.nq,))
        if v.shape != (robot.nv,):
            raise ShapeError("v", v.shape, (robot.nv,))
        q, v = q.astype(float), v.astype(float)
        if not take_state(q, v, self.live.q):
            raise NonFiniteError("the state (q, v) holds a NaN or an infinity")
        q.flags.writeable = v.flags.writeable = False
        self.stamp += 1
        return Kinematics(self, q, v, t)


class Kinematics:
    """Placements, Jacobians and drifts at exactly the state (`q`, `v`) and time `t` [s]."""

    __slots__ = (
        "_com",
        "_evaluator",
        "_has_com",
        "_has_drift",
        "_jacobians",
        "_motions",
        "_stamp",
        "q",
        "robot",
        "t",
        "v",
    )

    def __init__(self, evaluator: KinematicsEvaluator, q: Array, v: Array, t: float = 0.0) -> None:
        self._evaluator = evaluator
        self._stamp = evaluator.stamp
        self.robot = evaluator.robot
        self.q, self.v = q, v  # read-only copies
        self.t = t
        self._has_drift = self._has_com = False
        self._com: tuple[Array, Array] | None = None
        self._jacobians: dict[int, Array] | None = None  # made when the first is asked for
        self._motions: dict[int, Array] | None = None
        evaluator.compute(self.q)

    @property
    def pin_data(self) -> pin.Data:
        """Pinocchio's buffers at this state; `oMi`, `oMf` and `J` are up to date."""
        self._require_newest()
        return self._evaluator.pin_data

    @property
    def live(self) -> LiveArrays:
        """What kernels read: arrays that look into Pinocchio's buffers, of this state."""
        self._require_newest()
        return self._evaluator.live

    @property
    def live_with_drift(self) -> LiveArrays:
        """The same with `velocities` and `accelerations` up to date."""
        self._require_newest()
        if not self._has_drift:
            self._evaluator.compute_drift(self.q, self.v)
            self._has_drift = True
        return self._evaluator.live

    def _require_newest(self) -> None:
        if self._stamp != self._evaluator.stamp:
            raise StaleKinematicsError(
                "this Kinematics is older than its evaluator's newest one; keep what you need "
                "from it, or use a KinematicsEvaluator of your own"
            )

    def placement(self, frame_id: int) -> pin.SE3:
        """Return `T_world_frame`."""
        return self.pin_data.oMf[frame_id].copy()

    def jacobian(self, frame_id: int) -> Array:
        """Return the Jacobian (6, nv) of a frame: velocity of its origin, then angular velocity.

        Both are in world axes: `[p_dot; omega] = jacobian @ v`.
        """
        if self._jacobians is None:
            self._jacobians = {}
        J = self._jacobians.get(frame_id)
        if J is None:
            live = self.live
            carried = live.carries[live.joint_of[frame_id]]
            J = np.empty((6, self.robot.nv))
            frame_rows(live.columns, carried, live.frames[frame_id], J, 0)
            J.flags.writeable = False
            self._jacobians[frame_id] = J
        return J

    def twist(self, frame_id: int) -> Array:
        """Return (6,): velocity of the origin [m/s] and angular velocity [rad/s], world axes."""
        return self._motion(frame_id)[0]

    def drift(self, frame_id: int) -> Array:
        """Return `dJ/dt v` (6,) of `jacobian(frame_id)`: its acceleration at zero `dv/dt`."""
        return self._motion(frame_id)[1]

    def _motion(self, frame_id: int) -> Array:
        live = self.live_with_drift
        if self._motions is None:
            self._motions = {}
        motion = self._motions.get(frame_id)
        if motion is None:
            joint = live.joint_of[frame_id]
            motion = np.empty((2, 6))
            frame_motion(
                live.joints[joint],
                live.velocities[joint],
                live.accelerations[joint],
                live.frames[frame_id],
                motion,
            )
            self._motions[frame_id] = motion
        return motion

    @property
    def p_world_com(self) -> Array:
        """Centre of mass (3,) [m] in world axes."""
        return self._centre_of_mass()[0]

    @property
    def J_com(self) -> Array:
        """Jacobian (3, nv) of the centre of mass: `d p_world_com / dt = J_com v`."""
        return self._centre_of_mass()[1]

    def _centre_of_mass(self) -> tuple[Array, Array]:
        if self._com is None:
            live = self.live_with_com
            self._com = (_frozen(live.com), _frozen(live.com_rows))
        return self._com

    @property
    def live_with_com(self) -> LiveArrays:
        """The live arrays with `com` and `com_rows` up to date."""
        live = self.live
        if not self._has_com:
            pin.jacobianCenterOfMass(self.robot.model, self._evaluator.pin_data)
            self._has_com = True
        return live


def _frozen(array: Array) -> Array:
    copy = array.astype(float)
    copy.flags.writeable = False
    return copy


def _live_arrays(robot: Robot, pin_data: pin.Data) -> LiveArrays:
    model = robot.model
    q = robot.q_half_sitting
    pin.forwardKinematics(model, pin_data, q, np.ones(robot.nv), np.ones(robot.nv))
    pin.computeJointJacobians(model, pin_data, q)
    pin.updateFramePlacements(model, pin_data)
    pin.jacobianCenterOfMass(model, pin_data)
    carries = np.zeros((model.njoints, robot.nv))
    for joint_id in range(1, model.njoints):
        for ancestor in list(model.supports[joint_id])[1:]:
            joint = model.joints[ancestor]
            carries[joint_id, joint.idx_v : joint.idx_v + joint.nv] = 1.0
    joint_of = tuple(int(frame.parentJoint) for frame in model.frames)
    return LiveArrays(
        q=np.array(q),
        frames=pose_rows(pin_data.oMf),
        joints=pose_rows(pin_data.oMi),
        columns=pin_data.J.T,
        velocities=motion_rows(pin_data.v),
        accelerations=motion_rows(pin_data.a),
        com=pin_data.com[0],
        com_rows=pin_data.Jcom,
        carries=carries,
        joint_ids=np.array(joint_of, dtype=np.int64),
        joint_of=joint_of,
    )
