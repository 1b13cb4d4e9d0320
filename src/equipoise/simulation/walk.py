"""A walk in a run: the walker is told what feet feel, controller and plant which of them carry."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactPhases, Phase, PhaseChange, PhaseSettings
from equipoise.control.modes import Mode
from equipoise.runlog import Channel, TickRecord
from equipoise.simulation.build.setup import Setup
from equipoise.simulation.build.walk import WalkSetup
from equipoise.simulation.led_log import led_channels, write_led
from equipoise.simulation.lost_feet import NOT_THERE, LostFeet
from equipoise.simulation.sensors import Reading
from equipoise.spatial import Array
from equipoise.walking import BalanceFeedback, Leaning, PlannedStep, WalkEvent
from equipoise.walking.feasible import zmp_at
from equipoise.walking.feet import Stance
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
        setup: Setup,
        controller: WholeBodyController,
        ground: Ground,
        leaning: Leaning | None = None,
    ) -> None:
        self.walk, self.robot = walk, setup.robot
        self._balance = walk.balance(controller.dt)
        self.walker = walk.walker(self._balance)
        self.controller, self.ground = controller, ground
        self._rows = [setup.contacts.rows[name].start + NORMAL for name in walk.contacts]
        self._wrench_rows = {name: setup.contacts.rows[name] for name in walk.contacts}
        self._frames = [sole.frame for sole in walk.planner.feet.soles]
        self._carry: tuple[int, ...] = self.walker.supports
        self._seen = 0.0
        self._leaning = leaning
        self._air: PlannedStep | None = None  # the step that was lifted last
        feet = [c for c in setup.contacts.contacts if c.name in walk.contacts]
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
            walker.stop()
        self._seen = t
        loads = [float(reading.lam[row]) for row in self._rows]
        walker.advance(t, self.controller.dt, loads, lambda: self._soles(reading))
        self._air = walker.swinging or self._air
        phases = self.phases.update(t, self._planned(), self._wrenches(reading))
        supervisor = self.controller.supervisor
        if supervisor.mode in (Mode.RUN, Mode.DEGRADED):
            cause = self.lost.update(t, phases, reading)
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
        fell = any(phases[walk.contacts[foot]] in NOT_THERE for foot in (0, 1) if foot not in carry)
        names = [walk.contacts[foot] for foot in carry]
        anchors = {walk.contacts[foot]: walker.stance[foot] for foot in carry}
        self.controller.switch(names, "energy" if fell else "torque", anchors=anchors)
        for foot, name in enumerate(walk.contacts):
            self.ground.support(name, walker.stance[foot] if foot in carry else None)

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
        told: list[WalkEvent | PhaseChange] = list(self.walker.events)
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
        return [
            *balance,
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
        if self._balance is not None:
            record["walk/dcm_error"][:] = self._balance.off
            record["walk/aside"][:] = self._balance.p
            record["walk/zmp_shift"][:] = self._balance.zmp
        record["walk/steps"][:] = walker.put_down
        record["walk/clock"][:] = walker.clock.t, walker.clock.rate
        write_led(self.walk.targets, record)
