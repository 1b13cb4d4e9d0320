"""Rigid contacts that come and go: soles and points lift where they would pull, and land."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack, SoleContact
from equipoise.errors import InputError, NameNotFoundError
from equipoise.kinematics import Kinematics
from equipoise.physics.engine import PhysicsState, checked_torque
from equipoise.physics.no_objects import NoObjects
from equipoise.physics.pushed_object import PushedObject, PushedObjectState
from equipoise.physics.rigid.engine import RigidContactEngine, RigidOptions
from equipoise.physics.rigid.ground import Block, Ground
from equipoise.physics.rigid.impact import Impact, inelastic_impact
from equipoise.physics.rigid.landing import goes_into, height, landed, lifts, lowest
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_period

STANDS = 1e-4  # [m] over where its contact is, up to which a foot stands at the start
NORMAL = 2  # row of a sole, and of a point, along which it can only push


@dataclass(frozen=True)
class ContactEvent:
    """A contact lifted, or landed, at time `t` [s]; `kind` is "lift", "land" or "loss".

    `impulse` (k,) [N s, N m s] is what a landing gave in the rows of the contact, `lost` [J] the
    kinetic energy that it took. A "loss" is a contact that was taken away.
    """

    t: float
    kind: str
    name: str
    impulse: Array
    lost: float = 0.0


class UnilateralContactEngine(NoObjects):
    """Rigid bodies on a flat floor, and on the tops of `blocks`, whose soles and points only push.

    A sole or a point is released in the step in which its normal force would be negative. It lands
    in the step at whose start it is at the floor and goes down: of a sole a corner is at the height
    of what is under its middle, which goes down; sides and edges of blocks are not felt. A landing
    is an inelastic impact: all rows of what holds come to rest at once. A support that would have
    to pull in it, more than what it carries in a step, lifts instead; and what would have to be
    pulled down to rest does not land. From then on it stays where it landed: it never slips, and a
    sole neither rolls nor tips, whatever moment it would need; that is judged elsewhere. What force
    sensors read, `lam`, leaves the impulses out: they are in `events`. Contacts that do not support
    hold both ways.

    Between two events this is `RigidContactEngine`, with the contacts that hold then.
    Raises: `InputError` for pushed objects, which belong to that engine.
    """

    def __init__(
        self,
        robot: Robot,
        contacts: ContactStack,
        q_start: Array,
        control_dt: float,
        *,
        options: RigidOptions | None = None,
        v_start: Array | None = None,
        pushed: Sequence[PushedObject] = (),
        blocks: Sequence[Block] = (),
    ) -> None:
        if pushed:
            raise InputError(
                "objects that are pushed need contacts that hold both ways",
                given=[one.contact for one in pushed],
                remedy="Use the engine mujoco, or rigid with bilateral contacts",
            )
        options = options or RigidOptions()
        control_dt = real_period("the control period", control_dt)
        self.robot, self.contacts = robot, contacts
        self.substeps, self.h = options.substeps, control_dt / options.substeps
        self.sliders: Mapping[PushedObject, PushedObjectState] = {}
        self.external = np.zeros(robot.nv)
        self.events: list[ContactEvent] = []
        self._options = replace(options, substeps=1)
        self._feet = {c.name: c for c in contacts.contacts if lifts(c)}
        kin = robot.at(q_start)
        self._held = {
            c.name: c
            for c in contacts.contacts
            if not lifts(c) or lowest(c, kin)[0] < height(c) + STANDS
        }
        self._axes: dict[str, Array] = {}  # in which the wrench of a sole is told
        floor = min((height(c) for c in self._feet.values()), default=-math.inf)
        self.ground = Ground(floor, tuple(blocks))
        v = np.zeros(robot.nv) if v_start is None else v_start
        self._steps, self._control_dt = 0, control_dt
        self._lam = np.zeros(contacts.size)
        self._inside = self._engine(q_start, v)

    @property
    def state(self) -> PhysicsState:
        """The present state."""
        inside = self._inside.state
        return PhysicsState(self._t, inside.q, inside.v, self._lam.copy(), inside.violation)

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the contacts that hold now."""
        return tuple(self._held)

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period with `tau` (na,) [N m] held; return the new state.

        Raises: `InputError` for what is no finite torque, before anything moves; `DivergedError`.
        """
        tau = checked_torque(tau, self.robot.na)
        total = np.zeros(self.contacts.size)
        for _ in range(self.substeps):
            self._land()
            self._lift(tau)
            self._inside.external[:] = self.external
            state = self._inside.step(tau)
            for name, rows in self._inside.contacts.rows.items():
                total[self.contacts.rows[name]] += self._told(name, state.lam[rows])
            self._steps += 1
        self._lam = total / self.substeps
        return self.state

    def stand(self) -> Array:
        """Let the robot stand at rest where it is; return the torque (na,) [N m] for it."""
        tau = self._inside.stand()
        lam = self._inside.state.lam
        self._lam[:] = 0.0
        for name, rows in self._inside.contacts.rows.items():
            self._lam[self.contacts.rows[name]] = self._told(name, lam[rows])
        return tau

    def weigh(self, robot: Robot) -> None:
        """Let every link weigh what it does in `robot`, a copy of this one, from now on."""
        self.robot = robot
        self._inside.weigh(robot)

    def support(self, name: str, T_world_anchor: pin.SE3 | None) -> None:
        """Tell a sole's wrench in the axes of this anchor; what holds is for the floor to say.

        Raises: `NameNotFoundError`.
        """
        if name not in self._feet:
            raise NameNotFoundError("contact that can lift", name, self._feet)
        if T_world_anchor is not None and isinstance(self._feet[name], SoleContact):
            self._axes[name] = T_world_anchor.rotation.copy()

    def lose(self, name: str) -> None:
        """Take the floor away from a foot at once; it lands again where it comes to the floor.

        Raises: `NameNotFoundError` for what does not stand.
        """
        standing = [one for one in self._held if one in self._feet]
        if name not in standing:
            raise NameNotFoundError("foot that stands", name, standing)
        self._release([name], "loss")

    def remove(self, name: str) -> None:
        """Take the blocks of a body of the world away; what stood on them is lost.

        Raises: `NameNotFoundError`.
        """
        known = dict.fromkeys(one.name for one in self.ground.blocks)
        if name not in known:
            raise NameNotFoundError("box to stand on", name, known)
        left = tuple(one for one in self.ground.blocks if one.name != name)
        self.ground = Ground(self.ground.floor, left)
        kin = self.robot.at(self._inside.state.q)
        lost = []
        for foot in self._feet.keys() & self._held.keys():
            bottom, middle, _ = lowest(self._feet[foot], kin)
            if bottom > self.ground.under(middle) + STANDS:
                lost.append(foot)
        if lost:
            self._release(sorted(lost), "loss")

    # -- events ---------------------------------------------------------------------------------

    @property
    def _t(self) -> float:
        return self._steps * self.h

    def _engine(self, q: Array, v: Array) -> RigidContactEngine:
        """Return the engine of the contacts that hold now."""
        held = [self._held[c.name] for c in self.contacts.contacts if c.name in self._held]
        engine = RigidContactEngine(
            self.robot, ContactStack(held), q, self.h, options=self._options, v_start=v
        )
        engine.begin_at(self._steps)
        return engine

    def _lift(self, tau: Array) -> None:
        """Release what would have to pull, until nothing would."""
        force = self.external.copy()
        force[self.robot.nv_base :] += tau
        while self._feet.keys() & self._held.keys():
            _, lam = self._inside.accelerations(force)
            rows = self._inside.contacts.rows
            pulled = [n for n in self._feet if n in rows and lam[rows[n]][NORMAL] < 0.0]
            if not pulled:
                return
            self._release(pulled, "lift")

    def _release(self, names: Sequence[str], kind: str) -> None:
        for name in names:
            held = self._held.pop(name)
            self.events.append(ContactEvent(self._t, kind, name, np.zeros(held.size)))
        state = self._inside.state
        self._inside = self._engine(state.q, state.v)

    def _land(self) -> None:
        """Let feet land that are at the floor and go down."""
        free = [name for name in self._feet if name not in self._held]
        if not free:
            return
        state = self._inside.state
        kin = self.robot.at(state.q, state.v)
        landing = [n for n in free if goes_into(self.ground, self._feet[n], kin)]
        if not landing:
            return
        for name in landing:
            self._held[name] = landed(self._feet[name], kin)
        order = [c.name for c in self.contacts.contacts if c.name in self._held]
        impact, landing = self._impact(kin, state.v, order, landing)
        if not landing:
            return
        lifted = [one for one in order if one in self._held and one not in impact.impulses]
        for name in lifted:
            held = self._held.pop(name)
            self.events.append(ContactEvent(self._t, "lift", name, np.zeros(held.size)))
        for name in landing:
            impulse = self._told(name, impact.impulses[name])
            share = impact.lost / len(landing)
            self.events.append(ContactEvent(self._t, "land", name, impulse, share))
        self._inside = self._engine(state.q, impact.v)

    def _impact(
        self, kin: Kinematics, v: Array, names: Sequence[str], landing: Sequence[str]
    ) -> tuple[Impact, list[str]]:
        """Return the impact in which no foot pulls, and which of those that were at the floor land.

        A foot that stood before may pull as much as it carries in a step, which it then carries
        less of.
        """
        kept, coming = list(names), list(landing)
        carried = {
            name: self._lam[self.contacts.rows[name]][NORMAL] * self.h for name in self._feet
        }
        while True:
            found = inelastic_impact(self.robot, kin, v, [self._held[name] for name in kept])
            pulls = []
            for name in kept:
                least = 0.0 if name in landing else -max(carried.get(name, 0.0), 0.0)
                if name in self._feet and found.impulses[name][NORMAL] < least:
                    pulls.append(name)
            if not pulls or not coming:
                return found, coming
            for name in pulls:
                kept.remove(name)
                if name in coming:
                    coming.remove(name)
                    del self._held[name]

    def _told(self, name: str, wrench: Array) -> Array:
        """Return a multiplier in the axes in which it is told."""
        held = self._held.get(name)
        if name not in self._axes or not isinstance(held, SoleContact):
            return wrench
        R = self._axes[name].T @ held.T_world_anchor.rotation
        return np.concatenate((R @ wrench[:3], R @ wrench[3:]))
