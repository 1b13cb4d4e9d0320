"""The engine: robot, frictional floor and loose objects in MuJoCo, one control period a step."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.errors import InputError
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.physics.engine import PhysicsState
from equipoise.physics.mujoco.contact_forces import Wrench, multipliers
from equipoise.physics.mujoco.contact_pads import PadSensor
from equipoise.physics.mujoco.conversion import placement
from equipoise.physics.mujoco.health import HealthCheck, silence_log_file
from equipoise.physics.mujoco.library import load_mujoco
from equipoise.physics.mujoco.model import build_model
from equipoise.physics.mujoco.objects import Surroundings
from equipoise.physics.mujoco.options import MujocoOptions
from equipoise.physics.mujoco.world_model import weld_name
from equipoise.physics.pushed_object import PushedObject, PushedObjectMode, PushedObjectState
from equipoise.robots import Robot
from equipoise.spatial import Array


class MujocoEngine:
    """A robot among bodies with mass and friction, simulated by MuJoCo.

    Contacts are not constraints here: they happen. `lam` of a contact is what the force-torque
    sensors behind the pads read, in the contact's own rows, mean over the control period.
    `external` (nv,) is the generalised force of whoever pushes. `sliders` maps a pushed object's
    contact to how far that object has gone along its direction.

    Args: `robot` is the true robot; `pushed` maps a slider to the name of the loose object it
    stands for and the unit vector (3,) along which its travel counts.
    Raises: `InputError` if mujoco is not installed or cannot be given the world.
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
        v = np.zeros(robot.nv) if v_start is None else np.array(v_start, dtype=float)
        start = self._evaluator.at(q_start, v)
        self.model = build_model(
            self.mujoco,
            robot,
            contacts,
            start,
            self.surroundings,
            self.options,
            self.h,
            {slider.contact for slider in self._pushed},
        )
        self.simulated = self.mujoco.MjData(self.model.compiled)
        self._health = HealthCheck(self.mujoco, self.simulated)
        self._prepare_reading()
        self.external = np.zeros(robot.nv)
        self._ticks = 0
        self._lam = np.zeros(contacts.size)
        self._violation = 0.0
        self._write(q_start, v)
        self._start_positions = {
            name: self.object_pose(name).translation for name, _ in self._pushed.values()
        }

    def _prepare_reading(self) -> None:
        compiled = self.model.compiled
        self._sites = np.array([compiled.site(s.site).id for s in self.model.sensors], dtype=int)
        self._welds = [
            (
                [
                    compiled.equality(weld_name(thing.name, PadSensor(frame_id).body)).id
                    for frame_id, _ in thing.handles
                ],
                thing.let_go,
            )
            for thing in self.surroundings.loose
            if thing.handles
        ]
        self._slots = [
            (
                int(compiled.sensor(s.force).adr[0]),
                int(compiled.sensor(s.torque).adr[0]),
            )
            for s in self.model.sensors
        ]

    def _write(self, q: Array, v: Array) -> None:
        simulated, conversion = self.simulated, self.model.conversion
        conversion.write_q(q, simulated.qpos)
        conversion.write_v(q, v, simulated.qvel)
        self.mujoco.mj_forward(self.model.compiled, simulated)

    @property
    def state(self) -> PhysicsState:
        """The present state."""
        q = self.model.conversion.q(self.simulated.qpos)
        v = self.model.conversion.v(q, self.simulated.qvel)
        return PhysicsState(self._ticks * self._control_dt, q, v, self._lam.copy(), self._violation)

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period with `tau` (na,) [N m] held; return the new state.

        Raises: `EngineWarningError` if MuJoCo warned, reset itself or lost a number.
        """
        if tau.shape != (self.robot.na,):
            raise InputError(f"tau needs {self.robot.na} entries", given=tau.shape)
        simulated = self.simulated
        self._let_go(self._ticks * self._control_dt)
        readings = np.zeros(len(simulated.sensordata))
        for substep in range(self.substeps):
            q = self.model.conversion.q(simulated.qpos)
            force = self.external.copy()
            force[6:] += tau
            self.model.conversion.write_force(q, force, simulated.qfrc_applied)
            self._resist_sliding()
            self.mujoco.mj_step(self.model.compiled, simulated)
            readings += simulated.sensordata
            self._health.require(self._ticks * self._control_dt + (substep + 1) * self.h)
        self._ticks += 1
        state = self.state
        kin = self._evaluator.at(state.q, state.v, state.t)
        self._lam = self._read(kin, readings / self.substeps)
        self._violation = self._support_violation(kin)
        self._move_sliders()
        return self.state

    def _read(self, kin: Kinematics, readings: Array) -> Array:
        """Return `lam` (r,) from the mean of the sensors, in the rows of the state reached."""
        return multipliers(self.contacts, kin, self._wrenches(readings))

    def _wrenches(self, readings: Array) -> dict[int, Wrench]:
        found = {}
        for sensor, site, (force, torque) in zip(
            self.model.sensors, self._sites, self._slots, strict=True
        ):
            R = self.simulated.site_xmat[site].reshape(3, 3)
            # MuJoCo reads what the link does to the pad; the world does the opposite to it.
            found[sensor.frame_id] = (
                -R @ readings[force : force + 3],
                -R @ readings[torque : torque + 3],
            )
        return found

    def _support_violation(self, kin: Kinematics) -> float:
        """Return how far [m or rad] a supporting contact is from where it started."""
        supports = [c for c in self.contacts.contacts if c.supporting]
        return max((float(np.abs(c.residual(kin)).max()) for c in supports), default=0.0)

    def object_pose(self, name: str) -> pin.SE3:
        """Return where a loose object is in the world."""
        body = self.simulated.body(name)
        return placement(body.xpos, body.xquat)

    def object_twist(self, name: str) -> Array:
        """Return linear [m/s] and angular velocity [rad/s] (6,) of a loose object, world axes."""
        adr = int(self.model.compiled.joint(name).dofadr[0])
        qvel = self.simulated.qvel[adr : adr + 6]
        R = self.object_pose(name).rotation
        return np.concatenate((qvel[:3], R @ qvel[3:]))

    def _let_go(self, t: float) -> None:
        """Open the welds whose time has come."""
        for welds, when in self._welds:
            if t >= when - 1e-9:
                self.simulated.eq_active[welds] = 0

    def _resist_sliding(self) -> None:
        for thing in self.surroundings.loose:
            if thing.viscosity > 0.0:
                adr = int(self.model.compiled.joint(thing.name).dofadr[0])
                qvel = self.simulated.qvel[adr : adr + 2]
                self.simulated.qfrc_applied[adr : adr + 2] = -thing.viscosity * qvel

    def _move_sliders(self) -> None:
        for slider, (name, direction) in self._pushed.items():
            state, row = self.sliders[slider], self.contacts.rows[slider.contact].start
            way = self.object_pose(name).translation - self._start_positions[name]
            advanced = float(way @ direction) - state.travel
            state.travel += advanced
            touching = self._lam[row] > 1e-6
            moving = abs(advanced) > 1e-4 * self._control_dt
            state.mode = (
                PushedObjectMode.FREE
                if not touching
                else PushedObjectMode.SLIP
                if moving
                else PushedObjectMode.STICK
            )

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
        lam = np.linalg.lstsq(J[:, :6].T, gravity[:6], rcond=None)[0]
        self._lam[rows] = lam
        return (gravity - J.T @ lam)[6:]

    def write_mjcf(self, path: Path) -> Path:
        """Write the model as MJCF, to look at or to run elsewhere."""
        path.write_text(self.model.spec.to_xml(), encoding="utf-8")
        return path
