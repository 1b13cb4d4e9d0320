"""The control law (24): torques from errors and contact geometry, without a dynamic model.

It takes no inertia, Coriolis or gravity term. The only place where a model of the dynamics enters
at all is outside, once, when the adviser suggests the constant matrix `K_d`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

import numpy as np

from equipoise.compiled import entrance
from equipoise.compiled.workspace import Workspace, part_of
from equipoise.contacts import ContactStack
from equipoise.contacts.pull import least_regulated, least_wanted, refuse_pull
from equipoise.control.base_wrench.foot_bounds import ReactionBounds
from equipoise.control.interface import (
    Command,
    ControllerState,
    ControlStatus,
    Measurement,
    Reference,
    write_vector,
)
from equipoise.control.passivity.gains import ControlGains, require_gains
from equipoise.control.passivity.kernels import HELD, RUN, SATURATED, law_begin, law_tick
from equipoise.control.passivity.manifolds import ForceManifold, PostureManifold, Variants
from equipoise.control.passivity.memory import (
    FLAG_COUNT,
    LANDED,
    LIFTED,
    MAPPING,
    STARTED,
    SWITCHING,
    T_FORCE,
    T_POSTURE,
    T_SUPPORTS,
)
from equipoise.control.passivity.program import LawProgram, LoadSplit, index_of
from equipoise.errors import InputError
from equipoise.hqp.solvers.active_set.solve import SOLVE
from equipoise.kinematics.state import Kinematics, KinematicsMemory
from equipoise.kinematics.tree import fill_tree, tree_of
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, real_vector, require_period, time_of

Keep = Literal["torque", "energy"]
KEEPS: tuple[Keep, ...] = get_args(Keep)
LONG_AGO = -1e9  # [s] when the supports changed that never did
BEGIN, FINISH = 1, 2  # parts of a tick: what Python has to see before the rest stands between
STATUS = {
    RUN: ControlStatus.RUN,
    SATURATED: ControlStatus.SATURATED,
    HELD: ControlStatus.HELD,
}


@entrance
def law_alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, first: int, t: float, part: int
) -> int:
    """Run a tick of the law, or a part of it, in the parts of a workspace from `first` on."""
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, first)
    contacts, law = (
        part_of(floats, whole, tables, first + 1),
        part_of(floats, whole, tables, first + 2),
    )
    if part & BEGIN and not law_begin(tree, state, contacts, t):
        return HELD
    if not part & FINISH:
        return RUN
    bounds, rows, search = (
        part_of(floats, whole, tables, first + 3),
        part_of(floats, whole, tables, first + 4),
        part_of(floats, whole, tables, first + 5),
    )
    return law_tick(tree, state, contacts, law, bounds, rows, search, t)


class PassivityController:
    """Tracks posture and contact forces; `reset` and then `step` once every `dt` [s].

    Its whole memory lies in one workspace; `posture`, `force` (the manifolds), `base_reaction`,
    `tau`, `u`, `handover` look into it.
    Source: eqs. (21), (24). Differs from the print: `- ds_dF/dt` instead of `+` (only then does
    (26) follow); the rows of J_phi whose force is not regulated have zero force error; the six
    base rows of the torque go to the supporting contacts (`least_reaction`); integrals
    stop while a torque is clamped. With `damp_violation` s also holds `(I - Q_phi) dv`. With the
    projector `damping` Q_phi and J_phi^+ are those that are orthogonal in K_d (`NearestVelocity`),
    and `damp_violation` adds what violates the supporting rows alone. With
    `bounds` the base wrench is shared out within what a floor can give, by the loads that are
    "measured" or those that the "zmp" asks for (`split`). `filter_time` [s] is that of the
    `ReactionObserver` through which the law sees its supporting reaction. It makes a workspace of
    its own, or works `inside` one that was laid out by a program, in the parts from a
    number on.
    """

    def __init__(
        self,
        robot: Robot,
        contacts: ContactStack,
        gains: ControlGains,
        dt: float,
        *,
        bounds: ReactionBounds | None = None,
        filter_time: float = 0.0,
        split: LoadSplit = "measured",
        inside: tuple[Workspace, LawProgram, int] | None = None,
    ) -> None:
        require_support(robot, contacts)
        self.robot, self.dt = robot, require_period(dt)
        self.filter_time = not_negative("filter_time", filter_time, "s")
        require_gains(gains, self.dt)
        self._bounds, self._gains, self._split = bounds, gains, split
        if inside is None:
            self._lay_out(contacts)
        else:
            self._work_in(*inside, contacts)
        self.reset()

    def _lay_out(self, contacts: ContactStack) -> None:
        """Make a workspace for these contacts."""
        robot = self.robot
        program = LawProgram(robot, contacts.contacts, self._bounds, self._split)
        frames = list(dict.fromkeys(map(robot.frame_id, program.contacts.frames())))
        workspace = Workspace(
            {"tree": tree_of(robot.model, frames), **program.shapes(len(frames))},
            program.memory,
            [SOLVE],
        )
        fill_tree(workspace.tree, robot.model, frames)
        program.fill(workspace, lambda frame: frames.index(robot.frame_id(frame)))
        self._work_in(workspace, program, 1, contacts)

    def _work_in(
        self, workspace: Workspace, program: LawProgram, first: int, contacts: ContactStack
    ) -> None:
        """Work in the parts of a workspace from `first` on, laid out by a program."""
        self.program, self.workspace, self.first = program, workspace, first
        self.law = workspace.parts["law"]
        self._measured = workspace.parts["measured"]
        self._entrance = (workspace.floats, workspace.integers, workspace.tables, first)
        self._memory = KinematicsMemory(self.robot, workspace, first)
        self.asks_python = program.contacts.needs_python
        program.tune(workspace, self._gains, self.dt, self.filter_time)
        self.hold(contacts)

    def move_into(self, workspace: Workspace, first: int) -> None:
        """Go on in another workspace that its program laid out, from part `first` on.

        Its memory has to be restored there.
        """
        self._work_in(workspace, self.program, first, self.contacts)

    def hold(self, contacts: ContactStack) -> None:
        """Note which contacts hold, nothing else: a run goes on as if they always had."""
        self.contacts = contacts
        self.program.hold(self.workspace, contacts)
        gains, law = self._gains, self.law
        k, r = contacts.regulated_rows.size, contacts.size
        self._lam, self._lam_ref = law.lam[:r], law.lam_ref[:k]
        self._least = least_wanted(self.contacts.contacts)
        self._least_ref = least_regulated(self.contacts.contacts)
        self.posture = PostureManifold(
            self.robot.nv, alpha=gains.alpha, beta_p=gains.beta_p, k_ip=gains.k_ip,
            sgn=gains.sgn_p, bound=gains.integral_max, variants=variants_of(gains),
            inside=(law.posture, law.clock, T_POSTURE),
        )  # fmt: skip
        force = law.force.ravel()[: 6 * k].reshape(6, k)
        self.force = ForceManifold(
            k, beta_F=gains.beta_F, k_iF=gains.k_iF, sgn=gains.sgn_F,
            inside=(force, law.clock, T_FORCE),
        )  # fmt: skip

    @property
    def gains(self) -> ControlGains:
        """The gains; give other ones at any time: integrals and starting values stay."""
        return self._gains

    @gains.setter
    def gains(self, gains: ControlGains) -> None:
        require_gains(gains, self.dt)
        self.program.tune(self.workspace, gains, self.dt, self.filter_time)
        self._gains = gains
        posture, force = self.posture, self.force
        posture.alpha, posture.beta_p, posture.k_ip = gains.alpha, gains.beta_p, gains.k_ip
        posture.root, posture.adapt, posture.growth_max = variants_of(gains)
        force.beta_F, force.k_iF = gains.beta_F, gains.k_iF

    @property
    def tau(self) -> Array:
        """The last torque (na,) [N m]."""
        return self.law.tau

    @property
    def u(self) -> Array:
        """The last fully actuated law (nv,)."""
        return self.law.u_before

    @property
    def handover(self) -> Array:
        """What u would have jumped by (nv,) at the last change of contacts."""
        return self.law.handover

    @property
    def base_reaction(self) -> Array:
        """The last change F (k,) of the supporting reactions."""
        return self.law.reaction[: self.contacts.supporting_rows.size]

    @property
    def notes(self) -> dict[str, float]:
        """What a sole was about to do, in words, and since when [s]; nothing without bounds."""
        if not self.program.bounded:
            return {}
        return self.program.bounds.notes(self.workspace.parts["bounds"])

    def reset(self) -> None:
        """Forget everything: the next `step` starts the manifolds anew."""
        law = self.law
        for name in (
            "posture",
            "force",
            "u_before",
            "handover",
            "reaction",
            "lam_0",
            "found",
            "carried",
            "tau",
            "tau_slow",
            "s_slow",
            "settles",
            "clock",
        ):
            getattr(law, name)[...] = 0.0
        law.flags[:] = np.zeros(FLAG_COUNT)
        law.clock[T_SUPPORTS] = LONG_AGO
        self.hold(self.contacts)

    def switch(self, contacts: ContactStack, keep: Keep = "torque") -> None:
        """Let other contacts hold from the next `step` on, without a jump of the torque.

        Where the supporting contacts stay, the manifolds start anew, so that s_qp = 0 and s_qF = 0,
        and the integral of the posture stays; what u would jump by is added to it and fades with
        `gains.handover`. Where they change, what the torque carried is mapped to the contacts that
        hold from now on: the integral takes it over, and only what stands along regulated rows is
        left to fade. `keep` says what is continuous then: the "torque"; or the "energy" of a lost
        contact, whose force as it was last measured the others then bear at once.
        Raises: `InputError` for an unknown `keep`, or if nothing is left to support the base.
        """
        if keep not in KEEPS:
            raise InputError("unknown what is to be kept", given=keep, known=list(KEEPS))
        require_support(self.robot, contacts)
        law, before = self.law, self.contacts
        mapped = _names(before, supporting=True) != _names(contacts, supporting=True)
        if mapped:
            law.carried[:] = 0.0
            if keep == "energy":
                law.carried[:] = self._force_of_lost(contacts)
        known = self.program.contacts.contacts
        if any(index_of(known, contact) < 0 for contact in contacts.contacts):
            memory = self.state()
            self._lay_out(contacts)
            self._take(memory)
        same = _names(before) == _names(contacts)
        self.hold(contacts)
        if not (mapped and same):
            self.force.memory[:] = 0.0
        flags = self.law.flags
        if mapped:
            fewer = len(_names(contacts, supporting=True)) < len(_names(before, supporting=True))
            flags[MAPPING] = flags[STARTED] * (LIFTED if fewer else LANDED)
            self.law.found[:] = 0.0
            return
        flags[SWITCHING] = flags[STARTED]
        flags[STARTED] = 0

    def _force_of_lost(self, contacts: ContactStack) -> Array:
        """Return the generalised force (nv,) of supports that go, as in the last tick."""
        law, force = self.law, np.zeros(self.robot.nv)
        staying = set(contacts.rows)
        for contact in self.contacts.contacts:
            if contact.supporting and contact.name not in staying:
                rows = self.contacts.rows[contact.name]
                force += law.J[rows].T @ law.lam[rows]
        return force

    def _take(self, memory: Mapping[str, Array]) -> None:
        """Take over from another layout what does not depend on the contacts that are regulated."""
        for name in (
            "posture", "u_before", "handover", "carried", "tau", "tau_slow", "s_slow", "settles",
            "clock", "flags",
        ):  # fmt: skip
            getattr(self.law, name)[...] = memory[f"law.{name}"]
        for name in ("reaction", "lam_0"):
            kept, mine = memory[f"law.{name}"], getattr(self.law, name)
            size = min(len(kept), len(mine))  # supports that change are mapped, whatever is here
            mine[:size] = kept[:size]

    def take_over(self, tau: Array) -> None:
        """Begin from joint torques `tau` (na,) [N m] that are measured now, at the first `step`.

        For a robot that stands under its own servos: without it the first torque is zero but for
        the wanted forces. The difference fades like that of a switch.
        Raises: `ShapeError`, `NonFiniteError`.
        """
        law, base = self.law, self.robot.nv_base
        law.u_before[base:] = real_vector("tau", tau, self.robot.na)
        law.u_before[:base] = 0.0
        law.flags[SWITCHING] = 1

    def state(self) -> ControllerState:
        """Return a copy of the whole memory; `held` says which contacts hold, in their order."""
        known = self.program.contacts.contacts
        held = [index_of(known, contact) for contact in self.contacts.contacts]
        return {**self.workspace.memory(), "held": np.array(held, dtype=int)}

    def restore(self, state: ControllerState) -> None:
        """Continue from a memory that `state` returned, of this law or one laid out alike."""
        memory = dict(state)
        known, held = self.program.contacts.contacts, memory.pop("held")
        contacts = [known[k] for k in held]
        if contacts != list(self.contacts.contacts):
            self.hold(ContactStack(contacts))
        self.workspace.restore(memory)

    def step(self, t: float, measured: Measurement, reference: Reference) -> Command:
        """Return the torque at time `t` [s]. Never raises on values, never exceeds a limit.

        Raises: `ShapeError` if an array has the wrong shape, `InputError` if it holds no numbers,
        or if a contact that can only push is wanted to pull.
        """
        t = time_of(t)
        self._write(measured, reference)
        if self.asks_python:
            code = self._in_two(t)
        else:
            code = law_alone(*self._entrance, t, BEGIN | FINISH)
        return self.command(code)

    def _write(self, measured: Measurement, reference: Reference) -> None:
        law, state = self.law, self._measured
        write_vector("measured q", measured.q, state.q)
        write_vector("measured v", measured.v, state.v)
        write_vector("measured lam", measured.lam, self._lam)
        write_vector("reference q_ref", reference.q_ref, law.q_ref)
        write_vector("reference v_ref", reference.v_ref, law.v_ref)
        write_vector("reference lam_ref", reference.lam_ref, self._lam_ref)
        if (self._lam_ref < self._least_ref).any():
            for (row, least), wanted in zip(self._least.items(), self._lam_ref, strict=True):
                refuse_pull(row, least, float(wanted))

    def _in_two(self, t: float) -> int:
        """Run a tick whose contacts are asked from Python."""
        contacts, part = self.program.contacts, self.workspace.parts["law_contacts"]
        contacts.write_places(part, t)
        code: int = law_alone(*self._entrance, t, BEGIN)
        if code == HELD:
            return HELD
        contacts.write_plain(part, self.kinematics(t), self.law.J, self.law.at)
        return law_alone(*self._entrance, t, FINISH)

    def kinematics(self, t: float) -> Kinematics:
        """Return the kinematics of the last measured state, which the next tick makes stale."""
        self._memory.stamp += 1
        return Kinematics(self._memory, t)

    def command(self, code: int) -> Command:
        """Return the command that stands in the workspace after a tick that went as `code` says."""
        law = self.law
        if code == HELD:
            nothing = np.zeros(self.robot.nv)
            return Command(
                law.tau.copy(), ControlStatus.HELD, nothing, self.base_reaction.copy(), nothing
            )
        return Command(
            law.tau.copy(), STATUS[code], law.u.copy(), self.base_reaction.copy(), law.s.copy()
        )


def _names(contacts: ContactStack, *, supporting: bool = False) -> list[str]:
    """Return the names of contacts that support, or of regulated ones."""
    return [
        c.name for c in contacts.contacts if (c.supporting if supporting else bool(c.regulated))
    ]


def variants_of(gains: ControlGains) -> Variants:
    """Return the gains of the variants of the posture's integral."""
    return gains.root, gains.adapt, gains.growth_max


def require_support(robot: Robot, contacts: ContactStack) -> None:
    """Refuse contacts that leave a moving base to itself. Raises: `InputError`."""
    if robot.nv_base and not contacts.supporting_rows.size:
        raise InputError(
            "no contact supports the base",
            known=contacts.rows,
            remedy="Mark at least one contact (a sole) as supporting",
        )
