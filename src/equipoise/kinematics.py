"""Kinematics of one robot at one state: evaluated once a tick, read-only afterwards.

Nothing here reads a mass or an inertia except the centre of mass, which is only offered when it
is asked for: a controller that never asks is free of the dynamic model.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.errors import EquipoiseError, NonFiniteError, ShapeError
from equipoise.robots import Robot
from equipoise.spatial import Array

_WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class StaleKinematicsError(EquipoiseError):
    """A `Kinematics` was read after its evaluator had moved on to another state."""


class KinematicsEvaluator:
    """Computes `Kinematics`, reusing the buffers of one robot.

    `carries` (njoints, nv) is 1 where a velocity moves the body of a joint, else 0.
    Only the newest `Kinematics` of an evaluator may be read; an older one raises
    `StaleKinematicsError` instead of answering for the wrong state.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.pin_data = robot.model.createData()
        self.stamp = 0
        self.carries = np.zeros((robot.model.njoints, robot.nv))
        for joint_id in range(1, robot.model.njoints):
            for ancestor in list(robot.model.supports[joint_id])[1:]:
                joint = robot.model.joints[ancestor]
                self.carries[joint_id, joint.idx_v : joint.idx_v + joint.nv] = 1.0

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
        if not (np.isfinite(q).all() and np.isfinite(v).all()):
            raise NonFiniteError("the state (q, v) holds a NaN or an infinity")
        self.stamp += 1
        return Kinematics(self, q, v, t)


class Kinematics:
    """Placements, Jacobians and drifts at exactly the state (`q`, `v`) and time `t` [s]."""

    def __init__(self, evaluator: KinematicsEvaluator, q: Array, v: Array, t: float = 0.0) -> None:
        self._evaluator = evaluator
        self._stamp = evaluator.stamp
        self.robot = evaluator.robot
        self.q = _frozen(q)
        self.v = _frozen(v)
        self.t = t
        self._has_drift = False
        self._com: tuple[Array, Array] | None = None
        self._jacobians: dict[int, Array] = {}
        self._placements: dict[int, pin.SE3] = {}
        model, data = self.robot.model, evaluator.pin_data
        pin.computeJointJacobians(model, data, self.q)
        pin.updateFramePlacements(model, data)

    @property
    def pin_data(self) -> pin.Data:
        """Pinocchio's buffers at this state; `oMi`, `oMf` and `J` are up to date."""
        if self._stamp != self._evaluator.stamp:
            raise StaleKinematicsError(
                "this Kinematics is older than its evaluator's newest one; keep what you need "
                "from it, or use a KinematicsEvaluator of your own"
            )
        return self._evaluator.pin_data

    def placement(self, frame_id: int) -> pin.SE3:
        """Return `T_world_frame`; treat it as read-only."""
        data = self.pin_data
        T = self._placements.get(frame_id)
        if T is None:
            T = self._placements[frame_id] = data.oMf[frame_id].copy()
        return T

    def jacobian(self, frame_id: int) -> Array:
        """Return the Jacobian (6, nv) of a frame: velocity of its origin, then angular velocity.

        Both are in world axes: `[p_dot; omega] = jacobian @ v`.
        """
        J = self._jacobians.get(frame_id)
        if J is None:
            J = pin.getFrameJacobian(self.robot.model, self.pin_data, frame_id, _WORLD_ALIGNED)
            J.flags.writeable = False
            self._jacobians[frame_id] = J
        return J

    def point_speed_rows(self, joint_ids: Array, p_world: Array, directions: Array) -> Array:
        """Return rows (k, nv) that give the speed along `directions` (k, 3) of body points.

        Point i moves with joint `joint_ids[i]` (0: the world) and now lies at `p_world[i]` [m].
        All rows come from the one world Jacobian: a column acts where its joint carries the body.
        """
        lines = np.hstack((directions, _cross(p_world, directions)))
        return (lines @ self.pin_data.J) * self._evaluator.carries[joint_ids]

    def twist(self, frame_id: int) -> Array:
        """Return (6,): velocity of the origin [m/s] and angular velocity [rad/s], world axes."""
        return self.jacobian(frame_id) @ self.v

    def drift(self, frame_id: int) -> Array:
        """Return `dJ/dt v` (6,) of `jacobian(frame_id)`: its acceleration at zero `dv/dt`."""
        data = self.pin_data
        if not self._has_drift:
            pin.forwardKinematics(self.robot.model, data, self.q, self.v, np.zeros(self.robot.nv))
            self._has_drift = True
        return pin.getFrameClassicalAcceleration(
            self.robot.model, data, frame_id, _WORLD_ALIGNED
        ).vector

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
            data = self.pin_data
            J_com = pin.jacobianCenterOfMass(self.robot.model, data, self.q).copy()
            self._com = (_frozen(data.com[0]), _frozen(J_com))
        return self._com


def _frozen(array: Array) -> Array:
    copy = np.array(array, dtype=float)
    copy.flags.writeable = False
    return copy


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products (k, 3) of rows; `numpy.cross` costs ten times as much here."""
    product = np.empty_like(b)
    product[:, 0] = a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]
    product[:, 1] = a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2]
    product[:, 2] = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product
