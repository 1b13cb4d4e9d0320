"""The loop's end of the unitree wire: `rt/lowstate` is read, `rt/lowcmd` written.

A `LowState_` has neither the pose of the base nor what acts in contacts: those are NaN here, and
its inertial unit is passed on, so that somebody may estimate them. Select, or L2 with B, on the
remote control asks for the end.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.wire.end import AT_ONCE
from equipoise.wire.health import Health
from equipoise.wire.interface import (
    ROBOT_MODES,
    CommandMode,
    RobotCommand,
    RobotMode,
    RobotState,
    Stamps,
)
from equipoise.wire.packets import LARGEST, Fault
from equipoise.wire.unitree.dds import DdsEnd
from equipoise.wire.unitree.layout import LOW_CMD, LOW_STATE, Message, fields_of
from equipoise.wire.unitree.motors import Motors

TICK = 1e-3  # [s] of the counter in a state
ENABLED = 1  # mode of a motor that is to work
FAREWELLS = 3
# Two bytes of buttons in `wireless_remote`; source: the remote control of Unitree's Python SDK.
BUTTONS, SELECT, L2, B = slice(2, 4), 1 << 3, 1 << 5, 1 << 1


class UnitreeRobot:
    """A `RobotInterface` of a Unitree robot; `rows` is the number of contact multipliers.

    Who is heard first is heard to the end. The answered tick goes into a reserved word of the
    command, which Unitree's own software leaves at zero: a simulated robot in lockstep needs it.
    """

    def __init__(self, robot: Robot, rows: int, dds: DdsEnd) -> None:
        self.robot, self._rows, self._dds = robot, rows, dds
        self._motors = Motors.of(robot)
        self.dropped: Counter[Fault] = Counter()
        self._writer: int | None = None
        self._first_tick = self._last_tick = -1
        self._sequence = 0
        self._message = Message(LOW_CMD)
        self._stamps = Stamps(robot.nq_base, robot.nv_base)
        self._posture = np.zeros(robot.na)
        self._tau = np.zeros(robot.na)
        self._commands = self._driven = self._closed = False

    def read(self, timeout: float) -> RobotState | None:
        """Return the newest state not read before; see `RobotInterface`."""
        until = self._dds.now() + timeout
        while True:
            self._dds.wait(until)
            state = self._newest()
            if state is not None or self._dds.now() >= until:
                return state

    def _newest(self) -> RobotState | None:
        newest: RobotState | None = None
        for _ in range(AT_ONCE):
            taken = self._dds.take()
            if taken is None:
                break
            state = self._taken(*taken)
            if isinstance(state, Fault):
                self.dropped[state] += 1
            else:
                newest = state
        return newest

    def _taken(self, packet: bytes, writer: int) -> RobotState | Fault:
        fields = fields_of(packet, LOW_STATE)
        if fields is None:
            return Fault.CRC
        if self._writer not in (None, writer):
            return Fault.FOREIGN
        tick, places = int(fields["tick"]), self._motors.places
        if tick < self._last_tick:
            return Fault.OLD
        motors, imu = fields["motor_state"], fields["imu_state"]
        joints = motors["q"][places].astype(float), motors["dq"][places].astype(float)
        tau = motors["tau_est"][places].astype(float)
        w, x, y, z = (float(one) for one in imu["quat_wxyz"])
        unit = np.concatenate(((x, y, z, w), imu["gyroscope"], imu["accelerometer"]))
        said = int(fields["reserve"][0])  # by a simulated robot: what it does
        if said - 1 not in ROBOT_MODES and said:
            return Fault.VALUES
        if not all((np.abs(part) <= LARGEST).all() for part in (*joints, tau, unit)):
            return Fault.VALUES
        self._writer, self._last_tick = writer, tick
        if self._first_tick < 0:
            self._first_tick, self._message.fields["mode_machine"] = tick, fields["mode_machine"]
            self._tau = np.clip(tau, -self.robot.tau_max, self.robot.tau_max)  # what carries it now
        self._sequence += 1
        self._posture = joints[0]
        mode = RobotMode.DRIVEN if self._driven else RobotMode.WAITING
        if said:
            mode = RobotMode(said - 1)
        return self._state(tick, mode, joints, tau, unit, self._health(fields))

    def _health(self, fields: np.void) -> Health:
        motors = fields["motor_state"][self._motors.places]
        first, second = (int(byte) for byte in fields["wireless_remote"][BUTTONS])
        stop = bool(first & SELECT) or bool(first & L2 and second & B)
        hottest = motors["temperature"].max(axis=1).astype(float)
        return Health(hottest, motors["vol"].astype(float), motors["motorstate"].astype(int), stop)

    def _state(
        self,
        tick: int,
        mode: RobotMode,
        joints: tuple[Array, Array],
        tau: Array,
        unit: Array,
        health: Health,
    ) -> RobotState:
        t = (tick - self._first_tick) * TICK
        q = np.concatenate((np.full(self.robot.nq_base, np.nan), joints[0]))
        v = np.concatenate((np.full(self.robot.nv_base, np.nan), joints[1]))
        lam = np.full(self._rows, np.nan)
        stamps = self._stamps.note(t, q, v, lam)
        return RobotState(self._sequence, t, mode, stamps, q, v, lam, tau, unit, health)

    def write(self, command: RobotCommand) -> None:
        """Write a command: a torque without a servo, or the servos where it is to hold.

        Raises: `InputError`, see `RobotInterface`.
        """
        tau = real_vector("tau", command.tau, self.robot.na)
        if not (np.abs(tau) <= self.robot.tau_max).all():
            raise InputError("a commanded torque is beyond the limits of its joint", given=tau)
        if self._first_tick < 0:
            raise InputError("no robot has been heard yet", remedy="Read a state first")
        by_torque = command.mode is CommandMode.TORQUE
        motors, places = self._message.fields["motor_cmd"], self._motors.places
        posture = self._posture  # that of the moment
        if command.mode is CommandMode.POSTURE:
            posture = real_vector("posture", command.posture, self.robot.na)
        elif by_torque:
            self._tau = tau
        motors["mode"][places] = ENABLED
        motors["q"][places] = 0.0 if by_torque else posture
        motors["tau"][places] = self._tau
        motors["kp"][places] = 0.0 if by_torque else self._motors.kp
        motors["kd"][places] = 0.0 if by_torque else self._motors.kd
        answered = self._first_tick + round(command.t / TICK)
        self._message.fields["reserve"][:2] = answered + 1, command.mode
        self._commands, self._driven = True, self._driven or by_torque
        self._dds.send(self._message.packet())

    def close(self) -> None:
        """Let a robot that was commanded hold its posture by its servos, and leave."""
        if self._closed:
            return
        self._closed = True
        if self._commands:
            t = (self._last_tick - self._first_tick) * TICK
            for _ in range(FAREWELLS):
                self.write(RobotCommand(t, CommandMode.HOLD, self._tau))
        self._dds.close()
