"""The engine: robot, frictional floor and loose objects in MuJoCo, one control period a step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack, PointContact, SoleContact
from equipoise.errors import NameNotFoundError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics.engine import PhysicsState, checked_torque
from equipoise.physics.mujoco.contact_forces import ContactForces
from equipoise.physics.mujoco.conversion import quat_wxyz
from equipoise.physics.mujoco.health import HealthCheck, silence_log_file
from equipoise.physics.mujoco.library import load_mujoco
from equipoise.physics.mujoco.model import build_model
from equipoise.physics.mujoco.names import in_model
from equipoise.physics.mujoco.objects import Surroundings
from equipoise.physics.mujoco.options import MujocoOptions
from equipoise.physics.mujoco.period import Period
from equipoise.physics.mujoco.robot_model import body_name, principal_axes
from equipoise.physics.mujoco.simulated_objects import SimulatedObjects
from equipoise.physics.pushed_object import PushedObject, PushedObjectMode, PushedObjectState
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_period, real_vector

OPENING_ERROR = 1e-9  # [s]


class MujocoEngine:
    """A robot among bodies with mass and friction, simulated by MuJoCo.

    Contacts are not constraints here: they happen. `lam` of a contact is what the force-torque
    sensors behind the pads read, in the contact's own rows, mean over the control period.
    `external` (nv,) is the generalised force of whoever pushes. `sliders` maps a pushed object's
    contact to how far that object has gone along its direction.

    Args: `robot` is the true robot; `pushed` maps a slider to the name of the loose object it
    stands for and the unit vector (3,) along which its travel counts.
    Raises: `InputError` if mujoco is not installed or cannot be given the world, or for a period
    that is not positive.
    """

    def __init__(
        self,
        robot: Robot,
        contacts: ContactStack,
        q_start: Array,
        control_dt: float,
        *,
        options: MujocoOptions | None = None,
        surroundings: Surroundings | None = None,
        pushed: Mapping[PushedObject, tuple[str, Array]] | None = None,
        v_start: Array | None = None,
    ) -> None:
        control_dt = real_period("the control period", control_dt)
        self.mujoco = load_mujoco()
        silence_log_file(self.mujoco)
        self.options = options or MujocoOptions()
        self.surroundings = surroundings or Surroundings()
        self.robot, self.contacts = robot, contacts
        self.substeps = self.options.substeps
        self.h = control_dt / self.substeps
        self._control_dt = control_dt
        self._pushed = dict(pushed or {})
        self.sliders = {slider: PushedObjectState() for slider in self._pushed}
        self._evaluator = KinematicsEvaluator(robot)
        q_start = real_vector("q_start", q_start, robot.nq)
        v = np.zeros(robot.nv) if v_start is None else real_vector("v_start", v_start, robot.nv)
        self.model = build_model(
            self.mujoco,
            robot,
            contacts,
            self._evaluator.at(q_start, v),
            self.surroundings,
            self.options,
            self.h,
            {slider.contact: slider.pad for slider in self._pushed},
        )
        self.simulated = self.mujoco.MjData(self.model.compiled)
        self._health = HealthCheck(self.mujoco, self.simulated)
        self.external = np.zeros(robot.nv)
        self._ticks = 0
        self._lam, self._violation = np.zeros(contacts.size), 0.0
        self._write(q_start, v)
        self._prepare()

    def _write(self, q: Array, v: Array) -> None:
        simulated, conversion = self.simulated, self.model.conversion
        conversion.write_q(q, simulated.qpos)
        conversion.write_v(q, v, simulated.qvel)
        conversion.place_followers(simulated.qpos, simulated.qvel)
        self.mujoco.mj_forward(self.model.compiled, simulated)

    def _prepare(self) -> None:
        """Look up what every step needs: places in MuJoCo's memory, and that memory itself."""
        compiled, simulated = self.model.compiled, self.simulated
        self.objects = SimulatedObjects(compiled, simulated, self.surroundings.loose)
        self._period = Period(self.model.conversion, simulated, self.objects.sliding)
        self._forces = ContactForces(self.robot, self.contacts, compiled, self.model.sensors)
        self._site_axes = simulated.site_xmat
        self._starts = {
            name: self.objects.position(name).copy() for name, _ in self._pushed.values()
        }

    @property
    def state(self) -> PhysicsState:
        """The present state."""
        q, v = self.model.conversion.state(self.simulated.qpos, self.simulated.qvel)
        return PhysicsState(self._ticks * self._control_dt, q, v, self._lam.copy(), self._violation)

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period with `tau` (na,) [N m] held; return the new state.

        Raises: `InputError` for what is no finite torque, before anything moves;
        `EngineWarningError` if MuJoCo warned, reset itself or lost a number.
        """
        tau = checked_torque(tau, self.robot.na)
        period, simulated, compiled = self._period, self.simulated, self.model.compiled
        mj_step, t, fine = self.mujoco.mj_step, self._ticks * self._control_dt, True
        self.objects.let_go(t + OPENING_ERROR)
        period.force[:] = self.external
        period.force[self.robot.nv_base :] += tau
        period.begin()
        for _ in range(self.substeps):
            mj_step(compiled, simulated)
            t, fine = t + self.h, period.take_step()
            if not fine:
                break
        self._health.require(t, fine=fine)
        self._ticks += 1
        return self._reached()

    def _reached(self) -> PhysicsState:
        """Return the state after a control period, with what the contacts did in it."""
        t, period, forces = self._ticks * self._control_dt, self._period, self._forces
        q, v = period.q.copy(), period.v.copy()
        forces.read(q, v, t, period.readings / self.substeps, self._site_axes)
        self._lam, self._violation = forces.lam.copy(), forces.violation
        self._move_sliders()
        return PhysicsState(t, q, v, self._lam.copy(), self._violation)

    def support(self, name: str, T_world_anchor: pin.SE3 | None) -> None:
        """Read a sole's wrench in the axes of another place from now on; None: it is in the air.

        Raises: `NameNotFoundError`.
        """
        self._forces.anchor(name, T_world_anchor)

    @property
    def object_names(self) -> tuple[str, ...]:
        """Names of the loose objects."""
        return self.objects.names

    def object_pose(self, name: str) -> pin.SE3:
        """Return where a loose object is in the world. Raises: `NameNotFoundError`."""
        return self.objects.pose(name)

    def object_twist(self, name: str) -> Array:
        """Return linear [m/s] and angular velocity [rad/s] (6,) of a loose object, world axes.

        Raises: `NameNotFoundError`.
        """
        return self.objects.twist(name)

    def _move_sliders(self) -> None:
        for slider, (name, direction) in self._pushed.items():
            state, row = self.sliders[slider], self.contacts.rows[slider.contact].start
            gone = self.objects.position(name) - self._starts[name]
            advanced = float(gone @ direction) - state.travel
            state.travel += advanced
            if self._lam[row] <= 1e-6:
                state.mode = PushedObjectMode.FREE
            elif abs(advanced) > 1e-4 * self._control_dt:
                state.mode = PushedObjectMode.SLIP
            else:
                state.mode = PushedObjectMode.STICK

    def stand(self) -> Array:
        """Return the torque (na,) [N m] under which the true robot would stand at rest here.

        The least reaction of the supporting contacts carries the base, nothing else is touched.
        That reaction is then what is measured before the first step.
        """
        robot = self.robot
        q = self.state.q
        still = np.zeros(robot.nv)
        gravity = pin.rnea(robot.model, robot.model.createData(), q, still, still)
        rows = self.contacts.supporting_rows
        J = self.contacts.jacobian(self._evaluator.at(q, still))[rows]
        base = robot.nv_base
        lam = np.linalg.lstsq(J[:, :base].T, gravity[:base], rcond=None)[0]
        self._lam[rows] = lam
        return (gravity - J.T @ lam)[base:]

    def weigh(self, robot: Robot) -> None:
        """Let every link weigh what it does in `robot`, a copy of this one, from now on."""
        compiled = self.model.compiled
        for joint in range(1, robot.model.njoints):
            inertia, body = robot.model.inertias[joint], compiled.body(body_name(robot, joint)).id
            moments, axes = principal_axes(inertia)
            compiled.body_mass[body], compiled.body_ipos[body] = inertia.mass, inertia.lever
            compiled.body_inertia[body], compiled.body_iquat[body] = moments, quat_wxyz(axes)
        self.mujoco.mj_setConst(compiled, self.mujoco.MjData(compiled))
        self.robot = robot

    def set_sole_friction(self, friction: float) -> None:
        """Let soles and feet have another friction from the next step on. Raises: `InputError`."""
        replace(self.options, sole_friction=friction)  # refuses what is none
        compiled = self.model.compiled
        for contact in self.contacts.contacts:
            kind = {SoleContact: "sole", PointContact: "foot"}.get(type(contact))
            if kind is not None:
                compiled.geom(in_model(kind, contact.name)).friction[0] = friction

    def remove(self, name: str) -> None:
        """Let nothing touch a fixed body of the world any more. Raises: `NameNotFoundError`."""
        fixed = {body.name: len(body.shapes) for body in self.surroundings.fixed}
        if name not in fixed:
            raise NameNotFoundError("fixed body of the world", name, fixed)
        for k in range(fixed[name]):
            geom = self.model.compiled.geom(in_model("fixed", name, k))
            geom.contype, geom.conaffinity = 0, 0

    def write_mjcf(self, path: Path) -> Path:
        """Write the model as MJCF, to look at or to run elsewhere."""
        path.write_text(self.model.spec.to_xml(), encoding="utf-8")
        return path
