"""The robot's end of the unitree wire, for a simulated robot: writes `rt/lowstate`."""

from __future__ import annotations

from collections import Counter

import numpy as np

from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.wire.end import AT_ONCE
from equipoise.wire.interface import COMMAND_MODES, CommandMode, RobotCommand, RobotState
from equipoise.wire.packets import Fault
from equipoise.wire.unitree.dds import DdsEnd
from equipoise.wire.unitree.layout import LOW_CMD, LOW_STATE, Message, fields_of
from equipoise.wire.unitree.motors import Motors
from equipoise.wire.unitree.robot import TICK

STIFFEST = 1e4  # [N m/rad], [N m s/rad] of a servo that anybody may ask for


class UnitreeServer:
    """Speaks as the robot does: sends what its messages have, takes commands of one writer.

    A command is torque and servo: `tau + kp (q - q_meas) + kd (dq - dq_meas)`, on the state that
    was sent last. One that does not say which tick it answers is taken as fresh, as a robot would.
    """

    def __init__(self, robot: Robot, dds: DdsEnd, oldest: float) -> None:
        self.robot, self.oldest, self._dds = robot, oldest, dds
        self._motors = Motors.of(robot)
        self.dropped: Counter[Fault] = Counter()
        self._writer: int | None = None
        self._message, self._sent = Message(LOW_STATE), np.zeros((2, robot.na))
        self._message.fields["motor_state"]["mode"][self._motors.places] = 1
        self._sequence = 0

    def now(self) -> float:
        """Return the time [s] on a clock that only goes forward."""
        return self._dds.now()

    def wait(self, until: float) -> None:
        """Return once something has arrived, or at the time `until` [s]."""
        self._dds.wait(until)

    def receive(self, t: float) -> RobotCommand | None:
        """Return the newest good command that has arrived by the robot's time `t` [s]."""
        newest: RobotCommand | None = None
        for _ in range(AT_ONCE):
            packet = self._dds.take()
            if packet is None:
                break
            taken = self._taken(*packet, t)
            if isinstance(taken, Fault):
                self.dropped[taken] += 1
            elif newest is None or newest.mode is not CommandMode.HOLD:
                newest = taken
        return newest

    def _taken(self, packet: bytes, writer: int, t: float) -> RobotCommand | Fault:
        fields = fields_of(packet, LOW_CMD)
        if fields is None:
            return Fault.CRC
        if self._writer not in (None, writer):
            return Fault.FOREIGN
        motors = fields["motor_cmd"][self._motors.places]
        numbers = np.array([motors[name] for name in ("q", "dq", "tau", "kp", "kd")], dtype=float)
        q, dq, tau, kp, kd = numbers
        answered, mode = (int(word) for word in fields["reserve"][:2])
        if not np.isfinite(numbers).all() or mode not in COMMAND_MODES:
            return Fault.VALUES
        # a float of 32 bits may be above a limit of 64 by its last bit
        if (np.abs(tau) > self.robot.tau_max * (1.0 + 1e-6)).any() or not (
            (kp >= 0.0) & (kp <= STIFFEST) & (kd >= 0.0) & (kd <= STIFFEST)
        ).all():
            return Fault.VALUES
        at = t if answered == 0 else (answered - 1) * TICK
        if mode != CommandMode.HOLD and not -0.5 * TICK <= t - at <= self.oldest + 0.5 * TICK:
            return Fault.OLD
        self._writer = writer
        tau = tau + kp * (q - self._sent[0]) + kd * (dq - self._sent[1])
        limit = self.robot.tau_max
        return RobotCommand(at, CommandMode(mode), np.clip(tau, -limit, limit), q)

    def send(self, state: RobotState) -> RobotState:
        """Send what a `LowState_` has of a state; return it with its sequence number."""
        self._sequence += 1
        robot, fields, places = self.robot, self._message.fields, self._motors.places
        motors, imu = fields["motor_state"], fields["imu_state"]
        self._sent[0], self._sent[1] = state.q[robot.nq_base :], state.v[robot.nv_base :]
        fields["tick"], fields["reserve"][0] = round(state.t / TICK), state.mode + 1
        motors["q"][places], motors["dq"][places] = self._sent
        motors["tau_est"][places] = state.tau
        x, y, z, w = state.imu[:4]
        imu["quat_wxyz"] = w, x, y, z
        imu["gyroscope"], imu["accelerometer"] = state.imu[4:7], state.imu[7:10]
        self._dds.send(self._message.packet())
        return state._replace(sequence=self._sequence)

    def close(self) -> None:
        """Leave."""
        self._dds.close()


def require_ticks(period: float) -> None:
    """Refuse a period that the counter of a state cannot tell. Raises: `InputError`."""
    if abs(period / TICK - round(period / TICK)) > 1e-9 or period < TICK:
        raise InputError("the unitree wire counts milliseconds", given=period)
