"""Kinematics of one robot at one state: evaluated once, read-only afterwards.

Nothing here reads a mass or an inertia except the centre of mass, which is only computed when it
is asked for: a controller that never asks is free of the dynamic model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pinocchio as pin

from equipoise.compiled.workspace import Workspace
from equipoise.errors import EquipoiseError, InputError
from equipoise.kinematics.kernels import (
    WITH_COM,
    WITH_FRAMES,
    WITH_MOTION,
    evaluate,
    evaluate_more,
    frame_jacobian,
    frame_motion,
    state_of,
)
from equipoise.kinematics.tree import fill_frames, fill_tree, tree_of, tree_shapes
from equipoise.spatial import POSE_SIZE, Array, pose_row
from equipoise.spatial.numbers import real_vector

NO_ROTATION = 1e-2  # off unit length, more than any integration drifts


class Kinematic(Protocol):
    """What kinematics needs of a robot."""

    @property
    def model(self) -> pin.Model:
        """Pinocchio's model."""

    @property
    def nq(self) -> int:
        """Length of a configuration."""

    @property
    def nv(self) -> int:
        """Length of a velocity."""

    def frame_id(self, frame: str | int) -> int:
        """Return the id of a frame by its name, or the id itself if there is such a frame."""


class StaleKinematicsError(EquipoiseError):
    """A `Kinematics` was read after its memory had moved on to another state."""


class KinematicsMemory:
    """Where kinematics lie: parts of a workspace (part 0 the tree), and how often they changed."""

    def __init__(self, robot: Kinematic, workspace: Workspace, number: int) -> None:
        self.robot, self.workspace, self.number = robot, workspace, number
        self.stamp = 0
        self.state = list(workspace.parts.values())[number]
        self.entrance = (workspace.floats, workspace.integers, workspace.tables, number)
        self._with_frames: dict[tuple[int, ...], Workspace] = {}

    def with_frames(self, frames: Sequence[str | int]) -> Workspace:
        """Return a workspace of its own: this tree with these frames, this state with motion.

        It holds this state until the next call with the same frames.
        """
        ids = tuple(self.robot.frame_id(frame) for frame in frames)
        workspace = self._with_frames.get(ids)
        if workspace is None:
            workspace = self._with_frames[ids] = self._made(ids)
        for name in ("q", "v", "joints", "columns"):
            getattr(workspace.state, name)[...] = getattr(self.state, name)
        blocks = workspace.floats, workspace.integers, workspace.tables
        evaluate_more(*blocks, 1, WITH_FRAMES | WITH_MOTION | WITH_COM)
        return workspace

    def _made(self, ids: Sequence[int]) -> Workspace:
        """Return a workspace with this tree and these frames, without a state."""
        model = self.robot.model
        tree = next(iter(self.workspace.parts.values()))
        shapes = {
            "tree": tree_shapes(model.njoints, len(tree.chain), len(ids)),
            "state": state_of(model, len(ids)),
        }
        workspace = Workspace(shapes)
        for name in tree:
            if not name.startswith("frame"):
                getattr(workspace.tree, name)[...] = getattr(tree, name)
        fill_frames(workspace.tree, model, ids)
        return workspace


class KinematicsEvaluator:
    """Computes `Kinematics`, reusing the memory of one robot.

    Only the newest `Kinematics` of an evaluator may be read; an older one raises
    `StaleKinematicsError` instead of answering for the wrong state. `robot.at(q)` needs no
    evaluator and never gets stale, but makes its memory each time.
    """

    def __init__(self, robot: Kinematic) -> None:
        self.robot = robot
        self._memory = _memory_of(robot, ())
        self._is_free = robot.model.njoints > 1 and robot.model.joints[1].nq == POSE_SIZE

    def __deepcopy__(self, memo: object) -> KinematicsEvaluator:
        return KinematicsEvaluator(self.robot)  # views into a memory cannot be copied with it

    def at(self, q: Array, v: Array | None = None, t: float = 0.0) -> Kinematics:
        """Evaluate the kinematics at configuration `q` (nq,) and velocity `v` (nv,), zero if None.

        The time `t` [s] matters only to contacts that move by themselves.

        Raises: `InputError` if they are no numbers; `ShapeError`; `NonFiniteError`.
        """
        robot, memory = self.robot, self._memory
        q = real_vector("q", q, robot.nq)
        v = np.zeros(robot.nv) if v is None else real_vector("v", v, robot.nv)
        if self._is_free and not abs(math.hypot(*q[3:POSE_SIZE]) - 1.0) < NO_ROTATION:
            raise InputError(
                "the quaternion in q, its entries 3 to 6, is not of length 1",
                given=q[3:POSE_SIZE].tolist(),
                remedy="Its order is x, y, z, w; divide it by its length",
            )
        evaluate(*memory.entrance, q, v)
        memory.stamp += 1
        return Kinematics(memory, t)


class Kinematics:
    """Placements, Jacobians and drifts at exactly the state (`q`, `v`) and time `t` [s].

    A frame is given by its name (or its id).
    """

    def __init__(self, memory: KinematicsMemory, t: float = 0.0) -> None:
        self._memory = memory
        self._stamp = memory.stamp
        self.robot = memory.robot
        self.q, self.v = _frozen(memory.state.q), _frozen(memory.state.v)
        self.t = t
        self._jacobians: dict[int, Array] = {}
        self._motions: dict[int, Array] | None = None
        self._com: tuple[Array, Array] | None = None
        self._pin_data: pin.Data | None = None

    @property
    def memory(self) -> KinematicsMemory:
        """The memory that kernels read.

        Raises: `StaleKinematicsError` if it holds another state by now.
        """
        if self._stamp != self._memory.stamp:
            raise StaleKinematicsError(
                "this Kinematics is older than its evaluator's newest one; keep what you need "
                "from it, or use `robot.at`, which never gets stale"
            )
        return self._memory

    def with_frames(self, frames: Sequence[str | int]) -> Workspace:
        """Return a workspace with these frames placed: what kernels are called with.

        It holds this state until the next call with the same frames and the same memory.
        """
        return self.memory.with_frames(frames)

    @property
    def pin_data(self) -> pin.Data:
        """Pinocchio's own results at this state, for what these kernels do not offer."""
        if self._pin_data is None:
            model = self.robot.model
            data = self._pin_data = model.createData()
            pin.computeJointJacobians(model, data, self.q)
            pin.updateFramePlacements(model, data)
        return self._pin_data

    def joint_placement(self, joint: int) -> pin.SE3:
        """Return where Pinocchio's joint `joint` is in the world.

        Raises: `InputError` for a number that no joint has.
        """
        if not 0 <= joint < self.robot.model.njoints:
            raise InputError(
                f"the robot has joints 0 to {self.robot.model.njoints - 1}",
                given=joint,
                remedy="`robot.model.getJointId(name)` gives the number of a joint that exists",
            )
        row = self.memory.state.joints[joint]
        return pin.SE3(row[:9].reshape(3, 3).T.copy(), row[9:].copy())

    def placement(self, frame: str | int) -> pin.SE3:
        """Return `T_world_frame`."""
        one = self.robot.model.frames[self.robot.frame_id(frame)]
        return self.joint_placement(one.parentJoint) * one.placement

    def jacobian(self, frame: str | int) -> Array:
        """Return the Jacobian (6, nv) of a frame: velocity of its origin, then angular velocity.

        Both are in world axes: `[p_dot; omega] = jacobian @ v`.
        """
        frame_id = self.robot.frame_id(frame)
        J = self._jacobians.get(frame_id)
        if J is None:
            one = self.robot.model.frames[frame_id]
            J = np.zeros((6, self.robot.nv))
            frame_jacobian(*self.memory.entrance, one.parentJoint, pose_row(one.placement), J)
            J.flags.writeable = False
            self._jacobians[frame_id] = J
        return J

    def twist(self, frame: str | int) -> Array:
        """Return (6,): velocity of the origin [m/s] and angular velocity [rad/s], world axes."""
        return self._motion(frame)[0]

    def drift(self, frame: str | int) -> Array:
        """Return `dJ/dt v` (6,) of `jacobian(frame)`: its acceleration at zero `dv/dt`."""
        return self._motion(frame)[1]

    def _motion(self, frame: str | int) -> Array:
        frame_id, memory = self.robot.frame_id(frame), self.memory
        if self._motions is None:
            self._motions = {}
            evaluate_more(*memory.entrance, WITH_MOTION)
        motion = self._motions.get(frame_id)
        if motion is None:
            one = self.robot.model.frames[frame_id]
            motion = np.empty((2, 6))
            frame_motion(*memory.entrance, one.parentJoint, pose_row(one.placement), motion)
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
            evaluate_more(*self.memory.entrance, WITH_COM)
            state = self.memory.state
            self._com = (_frozen(state.com), _frozen(state.com_rows))
        return self._com


def kinematics_at(robot: Kinematic, q: Array, v: Array | None = None, t: float = 0.0) -> Kinematics:
    """Return the kinematics of a state in memory of its own: see `KinematicsEvaluator.at`."""
    return KinematicsEvaluator(robot).at(q, v, t)


def _memory_of(robot: Kinematic, frames: Sequence[int]) -> KinematicsMemory:
    workspace = Workspace(
        {
            "tree": tree_of(robot.model, frames),
            "state": state_of(robot.model, len(frames)),
        }
    )
    fill_tree(workspace.tree, robot.model, frames)
    return KinematicsMemory(robot, workspace, 1)


def _frozen(array: Array) -> Array:
    copy = array.copy()
    copy.flags.writeable = False
    return copy
