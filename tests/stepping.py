"""A robot in MuJoCo that shifts its weight, lifts a foot, and puts it down again: slow steps."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from equipoise import WholeBodyController
from equipoise.contacts import ContactStack, SoleContact
from equipoise.control import ReactionBounds
from equipoise.physics.mujoco import MujocoEngine, MujocoOptions
from equipoise.tasks import ComTask, FramePoseTask, JointLimitsTask, PostureTask
from equipoise.trajectories import LiveTarget
from equipoise.wbc import ControlSettings
from equipoise.wbc.doors import LoopSettings, gains_for

SEARCH = 0.03  # [m/s] at which a foot comes down, and goes on searching for the floor


def minimum_jerk(x: float) -> tuple[float, float]:
    """Return place and speed at x of [0, 1]."""
    x = min(max(x, 0.0), 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x), 30.0 * x * x * (1.0 - x) ** 2


@dataclass
class Record:
    """What a run showed, tick by tick."""

    t: list[float] = field(default_factory=list)
    base: list[float] = field(default_factory=list)  # [m]
    joints: list[float] = field(default_factory=list)  # [rad]
    jump: list[float] = field(default_factory=list)  # [N m] of any torque, from tick to tick
    switched: list[bool] = field(default_factory=list)
    loads: list[np.ndarray] = field(default_factory=list)  # [N] of each sole
    share: list[float] = field(default_factory=list)  # of the torque limits


class Stepper:
    """Robot, controller and engine; `shift`, `lift`, `put_down` and `rest` run them."""

    def __init__(self, robot, *, split="zmp", dt=0.001, delay=0.003, options=None, gains=None):
        self.robot, self.dt, self.t = robot, dt, 0.0
        q = robot.q_half_sitting
        kin = robot.at(q)
        self.soles = [SoleContact.standing(sole, kin) for sole in robot.soles]
        self.stack = ContactStack(self.soles)
        loop = LoopSettings(period=dt, delay=delay, rotor_inertia=0.05)
        self.com = LiveTarget(pin.SE3(np.eye(3), kin.p_world_com.copy()))
        self.feet = [LiveTarget(one.T_world_anchor) for one in self.soles]
        self.T_feet = [one.T_world_anchor.copy() for one in self.soles]
        self.p_com = kin.p_world_com.copy()
        levels = [
            [FramePoseTask(one.name, one.frame, target, rate=20.0)
             for one, target in zip(self.soles, self.feet, strict=True)],
            [JointLimitsTask("limits", robot, rate=5.0)],
            [ComTask("com", self.com, rate=5.0)],
            [PostureTask("posture", robot, q[robot.nq_base :])],
        ]  # fmt: skip
        settings = ControlSettings(
            gains or gains_for(robot, self.stack, q, loop), dt, bounds=ReactionBounds(),
            split=split, filter_time=0.02,
        )  # fmt: skip
        self.controller = WholeBodyController(robot, levels, self.stack, settings, q)
        self.engine = MujocoEngine(robot, self.stack, q, dt, options=options or MujocoOptions())
        self.controller.take_over(self.engine.stand())
        self.names = [one.name for one in self.soles]
        self.held = list(self.names)
        self.record, self._tau, self._switched = Record(), None, False
        self.events = []

    def centre(self, i):
        """Return the middle of a sole where its target is (3,) [m]."""
        sole = self.soles[i].sole
        middle = np.array([sole.x_min + sole.x_max, sole.y_min + sole.y_max, 0.0]) / 2.0
        return self.T_feet[i].act(middle)

    @property
    def middle(self):
        """The point between both soles (3,) [m]."""
        return 0.5 * (self.centre(0) + self.centre(1))

    def load(self, i):
        """Return the normal force [N] on a sole."""
        return float(self.engine.state.lam[self.stack.rows[self.names[i]]][2])

    def switch(self, held, keep="torque"):
        self.events.append((self.t, tuple(held), [round(self.load(i), 1) for i in range(2)]))
        self.controller.switch(held, keep)
        self.held, self._switched = list(held), True

    def tick(self):
        state, robot = self.engine.state, self.robot
        wrenches = {name: state.lam[self.stack.rows[name]] for name in self.held}
        command = self.controller.step(self.t, state.q, state.v, wrenches)
        dq = pin.difference(robot.model, command.q_ref, state.q)
        record, tau = self.record, command.tau.copy()
        record.t.append(self.t)
        record.base.append(float(np.abs(dq[:3]).max()))
        record.joints.append(float(np.abs(dq[6:]).max()))
        record.jump.append(0.0 if self._tau is None else float(np.abs(tau - self._tau).max()))
        record.switched.append(self._switched)
        record.loads.append(np.array([self.load(i) for i in range(2)]))
        record.share.append(float(np.abs(tau / robot.tau_max).max()))
        self._tau, self._switched = tau, False
        self.engine.step(tau)
        self.t = round(self.t + self.dt, 9)
        assert self.controller.supervisor.mode.name == "RUN", self.controller.story

    def rest(self, duration):
        for _ in range(round(duration / self.dt)):
            self.tick()

    def shift(self, goal, overshoot=0.008):
        """Lead the centre of mass over a point (x, y) [m], the ZMP at most `overshoot` [m] past it.

        The largest acceleration of a minimum-jerk way D in T is 5.77 D / T^2.
        """
        start = self.p_com.copy()
        way = np.array([goal[0], goal[1], start[2]]) - start
        duration = max(np.sqrt(5.77 * np.linalg.norm(way) * start[2] / (9.81 * overshoot)), 0.5)
        ticks = round(duration / self.dt)
        for k in range(ticks):
            s, ds = minimum_jerk(k / ticks)
            self.com.set(pin.SE3(np.eye(3), start + s * way), np.r_[ds / duration * way, 0, 0, 0])
            self.tick()
        self.p_com = start + way
        self.com.set(pin.SE3(np.eye(3), self.p_com), np.zeros(6))

    def swing(self, i, up, forward, duration, touch=None):
        """Move a foot by a way up and forward [m]; going down it goes on until it presses [N]."""
        T, ticks, k = self.T_feet[i].copy(), round(duration / self.dt), 0
        way, down = np.array([forward, 0.0, up]), np.array([0.0, 0.0, SEARCH if touch else 0.0])
        while k < ticks or (touch is not None and self.load(i) < touch):
            x = min(k / ticks, 1.0)
            s, ds = minimum_jerk(x)
            late = max(k - ticks, 0) * self.dt
            p = duration * (4.0 * x**3 - 7.0 * x**4 + 3.0 * x**5) - late
            dp = 12.0 * x**2 - 28.0 * x**3 + 15.0 * x**4
            self.T_feet[i] = pin.SE3(T.rotation, T.translation + s * way + p * down)
            self.feet[i].set(self.T_feet[i], np.r_[ds / duration * way + dp * down, 0, 0, 0])
            self.tick()
            k += 1
            assert late < 1.0, "the foot finds no floor"
            if touch is not None and x > 0.5 and self.load(i) > touch:
                break
        self.feet[i].set(self.T_feet[i], np.zeros(6))

    def step(self, i, forward=0.0, height=0.05):
        """Shift over the other foot, lift this one, put it down, and stand on both."""
        touch = 0.03 * self.robot.mass * 9.81
        self.shift(self.centre(1 - i)[:2])
        self.rest(0.2)
        self.switch([self.names[1 - i]])
        self.swing(i, height, forward / 2.0, 0.6)
        self.swing(i, -height, forward / 2.0, 0.6, touch)
        self.switch(self.names)
        self.rest(0.2)

    def summary(self):
        r = self.record
        on = np.array(r.switched)
        jump = np.array(r.jump)
        return dict(
            base_mm=1e3 * max(r.base), joints_mrad=1e3 * max(r.joints),
            switch_jump=float(jump[on].max()) if on.any() else 0.0,
            other_jump=float(jump[~on][20:].max()), share=max(r.share),
        )  # fmt: skip
