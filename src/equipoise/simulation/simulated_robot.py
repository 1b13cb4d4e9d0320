"""A plant as a robot: its state of the moment is read, a torque for one period is written."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.control.passivity.gain_advice import inertia_matrix
from equipoise.control.safe_hold import joint_damping
from equipoise.robots import Robot
from equipoise.simulation.plant import Plant
from equipoise.spatial import Array
from equipoise.spatial.numbers import require_period
from equipoise.wire.interface import CommandMode, RobotCommand, RobotMode, RobotState, Stamps

CARRIED_TIME = 0.1  # [s] over which the torque that carries the robot is averaged
SINKING = 2.0  # [s] in which the weight is let down
GRAVITY = 9.81  # [m/s^2]
GANTRY, GYRATION = 15.0, 0.3  # [rad/s], [m]: how stiff a gantry is for the mass that hangs in it
HOLD_ERROR, HOLD_TILT = 0.3, 0.3  # [rad] from the held posture beyond which holding is given up


class SimulatedRobot:
    """A `RobotInterface` whose time goes on by one `dt` [s] with every `write`.

    Told nothing more, it holds its posture by joint servos around the torque that carried it. If a
    joint or the base is led away from it, it lets its weight down, braking. While it is led to a
    posture, its base hangs in a gantry: servos alone do not balance a robot that stands.
    `tau` (na,) [N m] is what it stands by at first, None where nothing holds it.
    """

    def __init__(self, plant: Plant, dt: float, tau: Array | None) -> None:
        self.plant, self._dt = plant, require_period(dt)
        robot = plant.robot
        self.mode = RobotMode.WAITING
        self._state, self._ticks, self._sequence = plant.engine.state, 0, 0
        self._tau = np.zeros(robot.na) if tau is None else tau.copy()
        self._carried = self._tau.copy()
        self._held: Array | None = None  # the posture that is held (nq,)
        self._led: Array | None = None  # the posture of the joints that it is led to (na,)
        self._hung = self._state.q.copy()  # where the gantry keeps the base (nq,)
        self._mass = float(sum(one.mass for one in robot.model.inertias))
        self._sunk = 0  # periods since it was given up
        delay = self._dt + plant.faults.faults.command_delay
        self._stiffness, self._damping = servo_gains(robot, delay)
        self._stamps = Stamps(robot.nq_base, robot.nv_base)
        self._read_at = -1
        self._before = self._state.v[:3]  # linear velocity of the base a period ago

    @property
    def t(self) -> float:
        """The time [s] of the robot."""
        return self._ticks * self._dt

    @property
    def q(self) -> Array:
        """The true configuration (nq,)."""
        return self._state.q

    @property
    def v(self) -> Array:
        """The true velocity (nv,)."""
        return self._state.v

    def read(self, timeout: float) -> RobotState | None:
        """Return what the sensors show now; None if that was read, or is one of the missed ticks.

        Nothing is waited for: the time of this robot stands still between two commands.
        """
        if self._read_at == self._ticks:
            return None
        self._read_at = self._ticks
        reading = self.plant.read(self._state)
        if self._ticks and self.plant.tick_is_missed():
            return None
        self._sequence += 1
        stamps = self._stamps.note(self.t, reading.q, reading.v, reading.lam)
        imu = self._imu(reading.q, reading.v)
        return RobotState(
            self._sequence, self.t, self.mode, stamps, *reading, self._tau.copy(), imu
        )

    def _imu(self, q: Array, v: Array) -> Array:
        """Return what an inertial unit at the base's origin shows, with the errors of q and v."""
        if self.plant.robot.nv_base != 6:
            return np.zeros(0)
        linear, rate = self._state.v[:3], self._state.v[3:6]
        R = pin.Quaternion(self._state.q[3:7]).toRotationMatrix()
        felt = (linear - self._before) / self._dt + np.cross(rate, linear) + GRAVITY * R[2]
        return np.concatenate((q[3:7], v[3:6], felt))

    def write(self, command: RobotCommand) -> None:
        """Go on by one period with the torque, to a posture or holding. Raises: `DivergedError`."""
        if command.mode is CommandMode.TORQUE:
            self.mode, self._held = RobotMode.DRIVEN, None
            self._carried += (command.tau - self._carried) * min(self._dt / CARRIED_TIME, 1.0)
            self._go_on(command.tau)
        elif command.mode is CommandMode.POSTURE and self.mode is RobotMode.WAITING:
            self._go_to(command.posture)
        else:
            self.hold()

    def _go_to(self, posture: Array) -> None:
        """Go on by one period, led to a posture of the joints (na,) by its own servos."""
        robot, nq, nv = self.plant.robot, self.plant.robot.nq_base, self.plant.robot.nv_base
        self._led = np.clip(posture, robot.q_min, robot.q_max)
        away = self._led - self._state.q[nq:]
        tau = self._carried + self._stiffness * away - self._damping * self._state.v[nv:]
        self._go_on(np.clip(tau, -robot.tau_max, robot.tau_max), self._gantry())

    def _gantry(self) -> Array:
        """Return the generalised force (nv,) of a gantry: a spring and a damper at the base."""
        robot, force = self.plant.robot, np.zeros(self.plant.robot.nv)
        if robot.nv_base == 6:
            away = pin.difference(robot.model, self._state.q, self._hung)[:6]
            inertia = self._mass * np.repeat([1.0, GYRATION**2], 3)
            force[:6] = inertia * (GANTRY**2 * away - 2.0 * GANTRY * self._state.v[:6])
        return force

    def hold(self) -> None:
        """Go on by one period by its own servos. Raises: `DivergedError`."""
        if self._led is not None and self.mode is RobotMode.WAITING:
            self._go_to(self._led)
            return
        robot, nv = self.plant.robot, self.plant.robot.nv_base
        if self._held is None:
            self._held, self._sunk, self.mode = self._state.q.copy(), 0, RobotMode.HELD
        away = pin.difference(robot.model, self._state.q, self._held)
        tilt = float(np.linalg.norm(away[3:6])) if nv == 6 else 0.0
        if self.mode is RobotMode.HELD and (
            np.abs(away[nv:]).max() > HOLD_ERROR or tilt > HOLD_TILT
        ):
            self.mode = RobotMode.SUNK
        tau = self._carried - self._damping * self._state.v[nv:]
        if self.mode is RobotMode.HELD:
            tau += self._stiffness * away[nv:]
        else:
            tau -= min(self._sunk * self._dt / SINKING, 1.0) * self._carried
            self._sunk += 1
        self._go_on(np.clip(tau, -robot.tau_max, robot.tau_max))

    def _go_on(self, tau: Array, pushed: Array | None = None) -> None:
        self._tau = tau.copy()
        self._before = self._state.v[:3]
        self._state = self.plant.write(tau, self._state, pushed)
        self._ticks += 1

    def close(self) -> None:
        """Let go: nothing to do, its time stands still."""


def servo_gains(robot: Robot, delay: float) -> tuple[Array, Array]:
    """Return stiffness [N m/rad] and damping [N m s/rad] (na,) that each joint bears at a delay.

    The damping is that of `joint_damping`; with the least inertia I that the joint can meet, the
    stiffness D^2 / (4 I) is the largest with which it does not overshoot.
    """
    D = joint_damping(robot, robot.q_half_sitting, delay)
    inertia = 1.0 / np.diag(np.linalg.inv(inertia_matrix(robot, robot.q_half_sitting)))
    return D**2 / (4.0 * inertia[robot.nv_base :]), D
