"""A walk in a run: the walker is told what feet feel, controller and plant which of them carry."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactPhases, ContactStack, Phase, PhaseChange, PhaseSettings
from equipoise.control.modes import Mode
from equipoise.robots import Robot
from equipoise.runlog import Channel, TickRecord
from equipoise.simulation.build.walk import WalkSetup
from equipoise.simulation.led_log import led_channels, write_led
from equipoise.simulation.lost_feet import LostFeet
from equipoise.simulation.sensors import Reading
from equipoise.spatial import Array
from equipoise.walking import BalanceFeedback, Clip, Leaning, PlannedStep, Stick, WalkEvent
from equipoise.walking.feasible import zmp_at
from equipoise.walking.feet import Stance
from equipoise.walking.stick import AXES
from equipoise.wbc import WholeBodyController

NORMAL = 2  # row of a sole's wrench
PATIENCE = 0.025  # [s] that a sole may take to do what is newly planned: to be unloaded takes 22 ms
UNPLANNED = (Phase.TOUCHED, Phase.LATE, Phase.LOST)
PHASES = ", ".join(f"{one.code:g} {one.name.lower()}" for one in Phase)


class Ground(Protocol):
    """Whoever tells what soles feel: an engine, or a robot elsewhere."""

    def support(self, name: str, T_world_anchor: pin.SE3 | None) -> None:
        """Tell a sole's wrench in the axes of another place from now on; None: it is in the air."""


class WalkDriver:
    """Leads the targets of a run tick by tick, and switches supports at lift and touchdown."""

    def __init__(
        self,
        walk: WalkSetup,
        robot: Robot,
        contacts: ContactStack,
        controller: WholeBodyController,
        ground: Ground,
        leaning: Leaning | None = None,
    ) -> None:
        self.walk, self.robot = walk, robot
        self._balance = walk.balance(controller.dt)
        self.walker = walk.walker(self._balance)
        self.steered, self._sticks = walk.steered(self.walker), walk.sticks
        self._leads = self.walker if self.steered is None else self.steered
        self._stops = False
        self.controller, self.ground = controller, ground
        self._rows = [contacts.rows[name].start + NORMAL for name in walk.contacts]
        self._wrench_rows = {name: contacts.rows[name] for name in walk.contacts}
        self._frames = [sole.frame for sole in walk.planner.feet.soles]
        self._carry: tuple[int, ...] = self.walker.supports
        self._seen = 0.0
        self._leaning = leaning
        self._air: PlannedStep | None = None  # the step that was lifted last
        feet = [c for c in contacts.contacts if c.name in walk.contacts]
        self.phases = ContactPhases(
            feet, walk.contacts, PhaseSettings.for_weight(walk.weight, patience=PATIENCE)
        )
        self.lost = LostFeet(self.walker, self.robot, walk.contacts)
        self._ground = walk.planner.feet.support(self.walker.stance, self.walker.supports)
        self._known: tuple[object, ...] = (self.walker.stance, self.walker.supports)

    def before_tick(self, t: float, reading: Reading) -> None:
        """Lead the targets to time `t` [s], and switch the supports if a foot lifted or landed."""
        walker, walk = self.walker, self.walk
        if walk.spec.stop is not None and self._seen < walk.spec.stop <= t:
            self.stop()
        self._seen = t
        if self.steered is not None and not self._stops and self._sticks.moments:
            self.steered.stick = self._sticks.at(t)
        loads = [float(reading.lam[row]) for row in self._rows]
        self._leads.advance(t, self.controller.dt, loads, lambda: self._soles(reading))
        self._air = walker.swinging or self._air
        self.phases.update(t, self._planned(), self._wrenches(reading))
        missing = self.phases.missing
        supervisor = self.controller.supervisor
        if supervisor.mode in (Mode.RUN, Mode.DEGRADED):
            cause = self.lost.update(t, missing, reading)
            if cause:
                supervisor.give_up(t, cause)
        if self._leaning is not None:
            self._lead_aside(*self._leaning.at(t))
        if self._balance is not None:
            self._give_way(self._balance, reading)
        carry = walker.supports
        if carry == self._carry:
            return
        self._carry = carry
        fell = any(walk.contacts[foot] in missing for foot in (0, 1) if foot not in carry)
        names = [walk.contacts[foot] for foot in carry]
        anchors = {walk.contacts[foot]: walker.stance[foot] for foot in carry}
        self.controller.switch(names, "energy" if fell else "torque", anchors=anchors)
        for foot, name in enumerate(walk.contacts):
            self.ground.support(name, walker.stance[foot] if foot in carry else None)

    def stop(self) -> None:
        """Put the feet side by side at the next touchdown, and stand."""
        self._stops = True
        if self.steered is None:
            self.walker.stop()
        else:
            self.steered.stick = Stick()

    def steer(self, stick: Stick) -> None:
        """Walk as this stick says from now on; only of a walk that is steered, by no schedule."""
        if self.steered is not None and not self._stops:
            self.steered.stick = stick

    def _planned(self) -> list[str]:
        """Return the feet that are to carry by the plan, wherever the ground turned out to be."""
        air, s = self._air, self.walker.clock.t
        swings = air.foot if air is not None and air.lift <= s < air.land else None
        return [name for foot, name in enumerate(self.walk.contacts) if foot != swings]

    def _wrenches(self, reading: Reading) -> dict[str, Array]:
        return {name: reading.lam[rows] for name, rows in self._wrench_rows.items()}

    def _give_way(self, balance: BalanceFeedback, reading: Reading) -> None:
        """Lead the centre of mass aside, as far as the robot is from where it was to be."""
        walker, feet = self.walker, self.walk.planner.feet
        if self._known != (walker.stance, walker.supports):
            self._known = (walker.stance, walker.supports)
            self._ground = feet.support(walker.stance, walker.supports)
        row = self.walk.targets.centre.row(0.0)
        kin = self.robot.at(reading.q)
        planned = walker.plan.centre.at(walker.clock.t)._replace(p=row[9:11], v=row[12:14])
        balance.drag(planned, kin.p_world_com[:2], (kin.J_com @ reading.v)[:2])
        if balance.acts:
            balance.advance(zmp_at(walker.plan, self.walk.planner.settings, walker.clock.t),
                            self._ground)  # fmt: skip
            self._lead_aside(balance.p, balance.v)

    def _lead_aside(self, p: Array, v: Array) -> None:
        """Lead the centre of mass aside of where it is wanted, by p (2,) [m] at v [m/s]."""
        row = self.walk.targets.centre.row(0.0)
        aside, speed = np.array([*p, 0.0]), np.array([*v, 0.0])
        self.walk.targets.centre.write_point(row[9:12] + aside, row[12:15] + speed)

    def _soles(self, reading: Reading) -> Stance:
        """Return where the soles are, as measured."""
        kin = self.robot.at(reading.q)
        left, right = self._frames
        return kin.placement(left), kin.placement(right)

    @property
    def story(self) -> tuple[str, ...]:
        """What happened to the feet, in sentences, in the order in which it did."""
        told: list[WalkEvent | PhaseChange | Clip] = list(self.walker.events)
        told += self.steered.clips if self.steered is not None else []
        told += [change for change in self.phases.changes if change.phase in UNPLANNED]
        return tuple(str(one) for one in sorted(told, key=lambda one: one.t))

    @property
    def channels(self) -> list[Channel]:
        """What is logged of a walk: where it is wanted, and who carries."""
        plane = ("x", "y")
        balance = (
            []
            if self._balance is None
            else [
                Channel("walk/dcm_error", plane, "m", "divergent component from its plan"),
                Channel("walk/aside", plane, "m", "how far the wanted centre gave way"),
                Channel("walk/zmp_shift", plane, "m", "zero-moment point that leads it back"),
            ]
        )
        speeds = ("m/s", "m/s", "rad/s")
        steered = (
            []
            if self.steered is None
            else [
                Channel("walk/stick", AXES, speeds, "how fast it is wanted to walk"),
                Channel("walk/goes", AXES, speeds, "how fast its next step goes"),
            ]
        )
        return [
            *balance,
            *steered,
            Channel("walk/centre", ("x", "y", "z"), "m", "wanted centre of mass"),
            Channel("walk/zmp", plane, "m", "planned zero-moment point"),
            Channel("walk/dcm", plane, "m", "planned divergent component of motion"),
            Channel("walk/carries", ("left", "right"), "", "1: the foot is a support"),
            Channel("walk/phase", ("left", "right"), "", PHASES),
            Channel("walk/steps", ("put_down",), "", "steps that ended on the ground"),
            Channel("walk/clock", ("time", "rate"), ("s", ""), "clock of the plan"),
            *led_channels(self.walk.targets),
        ]

    def write(self, record: TickRecord) -> None:
        """Fill the views of the present tick."""
        walker = self.walker
        state = walker.plan.centre.at(walker.clock.t)
        record["walk/centre"][:] = self.walk.targets.centre.row(0.0)[9:12]
        record["walk/zmp"][:], record["walk/dcm"][:] = state.zmp, state.dcm
        record["walk/carries"][:] = [float(foot in self._carry) for foot in (0, 1)]
        record["walk/phase"][:] = [self.phases.phases[name].code for name in self.walk.contacts]
        if self.steered is not None:
            for name, stick in (("stick", self.steered.stick), ("goes", self.steered.goes)):
                record[f"walk/{name}"][:] = stick.forward, stick.left, stick.turn
        if self._balance is not None:
            record["walk/dcm_error"][:] = self._balance.off
            record["walk/aside"][:] = self._balance.p
            record["walk/zmp_shift"][:] = self._balance.zmp
        record["walk/steps"][:] = walker.put_down
        record["walk/clock"][:] = walker.clock.t, walker.clock.rate
        write_led(self.walk.targets, record)
