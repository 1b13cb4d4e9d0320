"""A robot in somebody's own MuJoCo model: its state, what touches it, and its motors.

Ours: base quaternion xyzw, base velocities in base axes, joints in the robot's order; a contact's
multipliers are the force of the world on the robot, in the rows of the contact.
MuJoCo: quaternion wxyz, base linear velocity in world axes, any order, and contact forces in axes
of each contact, on the second of its two shapes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.adapters.mujoco_fit import all_joints, fit_of
from equipoise.adapters.mujoco_motors import Motors
from equipoise.contacts import Contact, ContactStack, PointContact, SoleContact
from equipoise.contacts.base import KernelContact
from equipoise.contacts.sliding import SlidingContact
from equipoise.errors import InputError, NameNotFoundError
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.physics.mujoco.conversion import WXYZ_FROM_XYZW, XYZW_FROM_WXYZ, FollowerPlace
from equipoise.physics.mujoco.library import load_mujoco
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector

FREE_JOINT, JOINT_EQUALITY = 0, 2  # mjtJoint.mjJNT_FREE, mjtEq.mjEQ_JOINT


class MujocoState(NamedTuple):
    """`q` (nq,), `v` (nv,), and by contact its multipliers, as `WholeBodyController.step` asks."""

    q: Array
    v: Array
    wrenches: dict[str, Array]


class MujocoAdapter:
    """Reads a robot out of a compiled MuJoCo `model`, and writes its torques back.

    Joints are found by name, `prefix` before it; other joints of the model are left alone. Both
    models are compared once: joint for joint, the axis must lie where ours does. A fixed base may
    stand anywhere in MuJoCo's world; contacts are then told in the robot's own.
    `rotor_inertia` (na,) [kg m^2] is the armature that the joints have there and the robot does not
    know of, for `LoopSettings`: none for a robot that was read from an MJCF with it.
    Raises: `InputError` for what cannot be the same robot, and for joints without a plain motor;
    `NameNotFoundError` for a joint that MuJoCo does not have.
    """

    def __init__(self, robot: Robot, model: Any, *, prefix: str = "") -> None:
        self._mujoco = load_mujoco()
        self.robot, self.model = robot, model
        whole = [self._joint(prefix + name) for name in all_joints(robot)]
        joints = [whole[joint - robot.base.first_joint] for joint in robot.actuated]
        self._qpos = np.array([model.jnt_qposadr[j] for j in joints])
        self._dofs = np.array([model.jnt_dofadr[j] for j in joints])
        self._base = self._base_of(model.jnt_bodyid[joints[0]])
        self._T_theirs_ours = fit_of(robot, model, whole, self._base)
        self._followers = self._places_of_followers(whole)
        self._motors = Motors(robot, model, joints)
        own = np.asarray(robot.model.armature)[robot.nv_base :]
        self.rotor_inertia = np.maximum(model.dof_armature[self._dofs] - own, 0.0)
        # the bodies of a link, welded together, by Pinocchio's number of its joint
        self._links = [0, *([0] if robot.nv_base else []), *model.jnt_bodyid[whole]]
        if robot.nv_base:
            self._links[1] = model.jnt_bodyid[self._base]
        self._links = [int(model.body_weldid[body]) for body in self._links]
        self._is_mine = np.zeros(model.nbody, dtype=bool)
        self._is_mine[self._links[1:]] = True
        self._evaluator = KinematicsEvaluator(robot)

    def _joint(self, name: str) -> int:
        mujoco, model = self._mujoco, self.model
        number = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name))
        if number < 0:
            known = [model.joint(j).name for j in range(model.njnt)]
            raise NameNotFoundError("joint in the MuJoCo model", name, known)
        return number

    def _places_of_followers(self, whole: list[int]) -> list[FollowerPlace]:
        """Return the joints that follow others. Raises: `InputError` if nothing couples one."""
        robot, model, found = self.robot, self.model, []
        numbers = dict(zip(all_joints(robot), whole, strict=True))
        tied = [
            {int(one), int(other)}
            for kind, one, other in zip(
                model.eq_type, model.eq_obj1id, model.eq_obj2id, strict=True
            )
            if kind == JOINT_EQUALITY
        ]
        for name, (leader, ratio, offset) in robot.followers.items():
            joint = numbers[name]
            if not any(joint in pair for pair in tied):
                raise InputError(
                    f"joint {name!r} of robot {robot.name} follows {leader!r}, and nothing in the "
                    "MuJoCo model couples it",
                    remedy=f'Add <equality><joint joint1="{name}" joint2="{leader}" '
                    f'polycoef="{offset:g} {ratio:g} 0 0 0"/></equality>, or lock it in the YAML',
                )
            places = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
            found.append(FollowerPlace(*places, robot.joint_index(leader), ratio, offset))
        return found

    def _base_of(self, body: int) -> int:
        """Return the free joint that carries a body, -1 for none."""
        model, found = self.model, -1
        while body and found < 0:
            first = model.body_jntadr[body]
            if first >= 0 and model.jnt_type[first] == FREE_JOINT:
                found = int(first)
            body = model.body_parentid[body]
        if (found >= 0) != bool(self.robot.nv_base):
            ours, theirs = ("free", "fixed") if self.robot.nv_base else ("fixed", "free")
            raise InputError(
                f"the base of robot {self.robot.name} is {ours}, that in MuJoCo is {theirs}",
                remedy="Give the body of its base a <freejoint/>, or none, or load the robot with "
                "the other base",
            )
        return found

    def from_mujoco(
        self, data: Any, contacts: ContactStack | Iterable[Contact] = ()
    ) -> MujocoState:
        """Return the state in MuJoCo's `data`, and the multipliers of `contacts`.

        Of a sole: its wrench [N, N m] at the origin of its frame in the axes of its anchor; of a
        point: its force [N] in world axes; of a point on a surface: the pressure [N] along the
        normal; of others: the multipliers that come nearest to what touches their links. Contact
        forces are those of MuJoCo's last step. What touches a link counts for every contact on it.
        Raises: `InputError` for contacts in plain Python.
        """
        q, v = self._state(data)
        if isinstance(contacts, ContactStack):
            contacts = contacts.contacts
        held = tuple(contacts)
        if not held:
            return MujocoState(q, v, {})
        kin, touched = self._evaluator.at(q, v, float(data.time)), self._touched(data)
        return MujocoState(q, v, {c.name: self._multipliers(c, kin, touched) for c in held})

    def _state(self, data: Any) -> tuple[Array, Array]:
        base = self._base
        joints, rates = data.qpos[self._qpos], data.qvel[self._dofs]
        if base < 0:
            return joints, rates
        at, first = self.model.jnt_qposadr[base], self.model.jnt_dofadr[base]
        wxyz, linear = data.qpos[at + 3 : at + 7], data.qvel[first : first + 3]
        xyzw = wxyz[XYZW_FROM_WXYZ] / np.linalg.norm(wxyz)
        R = pin.Quaternion(xyzw).toRotationMatrix()
        q = np.concatenate((data.qpos[at : at + 3], xyzw, joints))
        return q, np.concatenate((R.T @ linear, data.qvel[first + 3 : first + 6], rates))

    def _touched(self, data: Any) -> dict[int, Array]:
        """Return by link what the world does to it (6,): force, moment about our world's origin."""
        model, contact = self.model, data.contact
        links = model.body_weldid[model.geom_bodyid[contact.geom]]
        mine = self._is_mine[links]
        acting = np.flatnonzero((mine[:, 0] != mine[:, 1]) & (contact.efc_address >= 0))
        six = np.zeros((len(acting), 6))
        for row, k in zip(six, acting.tolist(), strict=True):
            self._mujoco.mj_contactForce(model, data, k, row)
        second = mine[acting, 1]  # MuJoCo tells what the first shape does to the second
        axes = contact.frame[acting].reshape(-1, 3, 3) * np.where(second, 1.0, -1.0)[:, None, None]
        force = np.einsum("kij,ki->kj", axes, six[:, :3])
        moment = np.einsum("kij,ki->kj", axes, six[:, 3:]) + _cross(contact.pos[acting], force)
        touched: dict[int, Array] = {}
        wrenches = np.hstack((force, moment))
        for link, wrench in zip(links[acting, second.astype(int)].tolist(), wrenches, strict=True):
            touched[link] = touched[link] + wrench if link in touched else wrench
        if self._base < 0:
            T = self._T_theirs_ours
            return {link: T.actInv(pin.Force(w)).vector for link, w in touched.items()}
        return touched

    def _multipliers(self, contact: Contact, kin: Kinematics, touched: dict[int, Array]) -> Array:
        if not isinstance(contact, KernelContact):
            raise InputError(
                f"contact {contact.name!r} is in plain Python: what acts in it is not known here",
                remedy="Read its multipliers yourself, and add them to the wrenches by its name",
            )
        wrenches = {
            frame: self._wrench_on(frame, kin, touched) for frame in dict.fromkeys(contact.frames)
        }
        first = wrenches[contact.frames[0]]
        force, moment = first[:3], first[3:]
        if isinstance(contact, SoleContact):
            R = contact.T_world_anchor.rotation
            return np.concatenate((R.T @ force, R.T @ moment))
        if isinstance(contact, PointContact):
            return force.copy()
        if isinstance(contact, SlidingContact):
            return np.array([contact.normal(kin) @ force])
        acting = sum(kin.jacobian(frame).T @ wrench for frame, wrench in wrenches.items())
        found = np.linalg.lstsq(contact.jacobian(kin).T, acting, rcond=None)[0]
        return np.asarray(found, dtype=float)

    def _wrench_on(self, frame: str | int, kin: Kinematics, touched: dict[int, Array]) -> Array:
        """Return force and moment (6,) on the link of a frame, at its origin, in world axes."""
        link = self._links[self.robot.model.frames[self.robot.frame_id(frame)].parentJoint]
        wrench = touched.get(link)
        if wrench is None:
            return np.zeros(6)
        at, force = kin.placement(frame).translation, wrench[:3]
        return np.concatenate((force, wrench[3:] - _cross(at, force)))

    def apply(self, data: Any, tau: Array) -> None:
        """Let the motors give the joint torques `tau` (na,) [N m], until this is called again.

        A motor behind a gear is told the torque over its gear; where the model has no motor for any
        joint, the torque goes to `qfrc_applied`. Raises: `ShapeError`, `InputError`.
        """
        self._motors.apply(data, real_vector("tau", tau, self.robot.na))

    def place(self, data: Any, q: Array, v: Array | None = None) -> None:
        """Put the robot at `q` (nq,), moving with `v` (nv,), at rest if None; nothing else moves.

        Raises: `ShapeError`, `NonFiniteError`, `InputError`.
        """
        robot, base = self.robot, self._base
        q = real_vector("q", q, robot.nq)
        v = np.zeros(robot.nv) if v is None else real_vector("v", v, robot.nv)
        data.qpos[self._qpos], data.qvel[self._dofs] = q[robot.nq_base :], v[robot.nv_base :]
        for one in self._followers:
            leader = robot.nq_base + one.leader, robot.nv_base + one.leader
            data.qpos[one.qpos] = one.ratio * q[leader[0]] + one.offset
            data.qvel[one.dof] = one.ratio * v[leader[1]]
        if base >= 0:
            at, first = self.model.jnt_qposadr[base], self.model.jnt_dofadr[base]
            data.qpos[at : at + 3] = q[:3]
            data.qpos[at + 3 : at + 7] = q[3:7][WXYZ_FROM_XYZW]
            R = pin.Quaternion(q[3:7]).toRotationMatrix()
            data.qvel[first : first + 3], data.qvel[first + 3 : first + 6] = R @ v[:3], v[3:6]
        self._mujoco.mj_forward(self.model, data)


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products along the last axis; `numpy.cross` takes ten times as long."""
    return a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]
