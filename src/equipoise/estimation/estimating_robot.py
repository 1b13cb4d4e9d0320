"""A robot whose base and contact forces are estimated, before one that does not measure them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from equipoise.contacts import ContactSchedule, ContactStack, SoleContact
from equipoise.errors import InputError
from equipoise.estimation.base_filter import BaseFilter, FilterNoise
from equipoise.estimation.wrench_observer import WrenchObserver
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.wire.interface import RobotCommand, RobotInterface, RobotState

FILTER_TIME = 0.004  # [s] of the observer of contact forces


class EstimatingRobot:
    """A `RobotInterface` that fills in base and contact forces of the robot behind it.

    `contacts` are all of them, in the order of the multipliers, `schedule` says which hold. Forces
    are estimated only where the robot measures none.
    """

    def __init__(
        self,
        behind: RobotInterface,
        robot: Robot,
        contacts: ContactStack,
        schedule: ContactSchedule,
        *,
        rotor_inertia: float = 0.0,
        noise: FilterNoise | None = None,
    ) -> None:
        soles = [one for one in contacts.contacts if isinstance(one, SoleContact)]
        if any(one.supporting for one in contacts.contacts if one not in soles):
            raise InputError("only soles that lie flat tell where the base is")
        self.behind, self.robot, self._contacts, self._schedule = behind, robot, contacts, schedule
        self.base = BaseFilter(robot, soles, noise)
        self.forces = WrenchObserver(robot, FILTER_TIME, rotor_inertia)
        self.follows: Callable[[float], float] = _same_time  # gives the time of the schedule
        self._t = -np.inf
        self._last: tuple[Array, Array, Array] | None = None  # base pose, twist, multipliers

    def read(self, timeout: float) -> RobotState | None:
        """Return the newest state not read before, with what it lacks; see `RobotInterface`."""
        state = self.behind.read(timeout)
        return None if state is None else self._filled(state)

    def _filled(self, state: RobotState) -> RobotState:
        nq, nv = self.robot.nq_base, self.robot.nv_base
        known = state.q[nq:], state.v[nv:], state.imu, state.tau
        if state.imu.shape != (10,) or not all(np.isfinite(part).all() for part in known):
            return state  # the supervisor bridges what is missing
        if self._last is None or state.t > self._t:  # else it is the same moment once more
            dt = 0.0 if self._last is None else state.t - self._t
            pose, twist = self.base.step(dt, state.q[nq:], state.imu)
            q, v = np.concatenate((pose, state.q[nq:])), np.concatenate((twist, state.v[nv:]))
            held = self._schedule.at(self.follows(state.t))
            if self._last is None:
                self.forces.begin(held, q, v, state.tau, state.t)
            else:
                self.forces.step(dt, q, v, state.tau)
            self._t, self._last = state.t, (pose, twist, self._multipliers(held, q, state.t))
        pose, twist, lam = self._last
        stamps = state.stamps.copy()
        stamps[0] = stamps[2] = state.t
        return state._replace(
            q=np.concatenate((pose, state.q[nq:])),
            v=np.concatenate((twist, state.v[nv:])),
            lam=state.lam if np.isfinite(state.lam).all() else lam,
            stamps=stamps,
        )

    def _multipliers(self, held: ContactStack, q: Array, t: float) -> Array:
        """Return the multipliers (r,) of all contacts, zero of those that do not hold."""
        lam = np.zeros(self._contacts.size)
        for name, part in held.split(self.forces.multipliers(held, q, t)).items():
            lam[self._contacts.rows[name]] = part
        return lam

    def write(self, command: RobotCommand) -> None:
        """Give a command; see `RobotInterface`."""
        self.behind.write(command)

    def close(self) -> None:
        """Let go of the robot."""
        self.behind.close()


def _same_time(t: float) -> float:
    return t
