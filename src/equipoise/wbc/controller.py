"""The whole controller in one object: robot, contacts, levels of tasks, gains, supervisor."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.compiled.workspace import Workspace
from equipoise.contacts import (
    Contact,
    ContactSchedule,
    ContactStack,
    PointContact,
    SoleContact,
)
from equipoise.control import (
    Command,
    Controller,
    Measurement,
    PassivityController,
    Reference,
    Supervisor,
)
from equipoise.control.interface import write_vector
from equipoise.control.modes import Mode
from equipoise.control.passivity.law import KEEPS, STATUS, Keep, require_support
from equipoise.control.passivity.program import LawProgram
from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.given import mapping_of
from equipoise.hqp import HierarchySolver, Status, make_solver
from equipoise.kinematics.tree import fill_tree, tree_of
from equipoise.motion import MotionGenerator
from equipoise.motion.generator import STAGES, STATUS_OF
from equipoise.motion.governor import bring_to_stand
from equipoise.motion.levels import Wishes
from equipoise.motion.memory import CLOCK_RATE, CLOCK_TIME, GOVERNED
from equipoise.motion.memory import STATUS as MOTION_STATUS
from equipoise.motion.program import MotionProgram
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive, real_array, real_vector, require_period, time_of
from equipoise.tasks import Task
from equipoise.trajectories import Fade
from equipoise.trajectories.scalars import Scalar, fill_scalars, scalar_shapes
from equipoise.wbc.command import WholeBodyCommand
from equipoise.wbc.doors import Forces, LoopSettings, Opened, Wish, mount, stand
from equipoise.wbc.memory import FADING, LEANING, PERIOD, POSTURE_ERROR, TILT, meeting_shapes
from equipoise.wbc.settings import ControlSettings
from equipoise.wbc.supports import Supports
from equipoise.wbc.tick import (
    ASKED,
    BEGIN_LAW,
    BEGIN_MOTION,
    MEASURED,
    MOVE,
    RUN_LAW,
    SUPERVISED,
    WANT,
    WHOLE,
    tick,
)
from equipoise.wbc.wanted import WantedForces

Wrenches = Array | Mapping[str, Array]
NewController = Callable[[ContactStack], Controller]


class WholeBodyController:
    """Turns a measured state into torques: motion generation, law and supervisor, tick by tick.

    `levels` are tasks, highest priority first; level 0 usually holds a `ContactTask`. `contacts`
    are what the law knows to hold, a stack or a schedule. `wanted_forces` gives by contact the
    wanted multiplier of each regulated row as a function of time; a contact that can only push is
    never wanted to pull: a profile that does is refused, a function of one's own gets zero instead.
    `fades` tells which tasks come and go. With the passivity law and our own solver a tick is one
    call of a kernel; `controller` makes another one, whose ticks are then its own. With a governor,
    tasks, fades and wanted forces are those of its clock, which may be behind the time; contacts
    then must not come or go.
    Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
    """

    def __init__(
        self,
        robot: Robot,
        levels: Sequence[Sequence[Task]],
        contacts: ContactStack | ContactSchedule,
        settings: ControlSettings,
        q_start: Array,
        *,
        wanted_forces: Mapping[str, Sequence[Scalar]] | None = None,
        fades: Mapping[str, Fade] | None = None,
        controller: NewController | None = None,
    ) -> None:
        self.robot, self.settings, self.followed_at = robot, settings, 0.0
        self.dt = require_period(settings.period)
        if isinstance(contacts, ContactStack):
            contacts = ContactSchedule(contacts.contacts, {})
        self.schedule, self.supports = contacts, Supports(contacts)
        self._held = contacts.at(0.0)
        self._keep: Keep = "torque"
        require_support(robot, self._held)
        self.wants = WantedForces(contacts.contacts, mapping_of("the wanted forces", wanted_forces))
        q = real_vector("q_start", q_start, robot.nq)
        self.motion = self._make_motion(levels, q, dict(fades or {}))
        if settings.governor is not None and len(contacts.stacks) > 1:
            raise InputError(
                "a governor slows the clock of the tasks, and contacts come and go by the time",
                given=[name for name, w in contacts.windows.items() if np.isfinite(w).any()],
                remedy="Leave out the governor, or the windows of the contacts",
            )
        self.motion.lay_out_again = self._lay_out_again
        self._law_program = LawProgram(robot, contacts.contacts, settings.bounds, settings.split)
        self._lay_out(self._law_program)
        self.law: PassivityController | None = None
        self.controller: Controller
        if controller is None:
            self.controller = self.law = self._make_law()
        else:
            self.controller = controller(self._held)
        self.supervisor = Supervisor(self.controller, settings.limits, bounds=settings.bounds)
        self._fused = self._runs_in_one_call()
        self._hold(self._held)

    @classmethod
    def standing(
        cls,
        robot: Robot,
        q_start: Array | None = None,
        *,
        tasks: Wishes = (),
        contacts: Sequence[Contact] = (),
        forces: Forces | None = None,
        feet: Sequence[str] | None = None,
        loop: LoopSettings | None = None,
    ) -> WholeBodyController:
        """Return a controller of a robot that stands where `q_start` (nq,) puts its feet.

        Level 0 holds the contacts, level 1 joint limits and balance, then come `tasks`, highest
        priority first (a task, or a list of tasks that share a level), at last the posture
        `q_start`, half-sitting if None. `feet` names soles, or frames that stand as points; None
        means every sole. `contacts` hold beside them, pressed by `forces`: by contact a number [N],
        which `want` can change, or a function of time, one for each regulated row. Gains come from
        the adviser for a `loop` on a floor that gives; the base wrench is shared out within what
        the floor can give.
        Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
        """
        wish = Wish(tasks, contacts, forces)
        return cls._of(robot, stand(robot, q_start, feet, wish, loop or LoopSettings()))

    @classmethod
    def fixed(
        cls,
        robot: Robot,
        q_start: Array | None = None,
        *,
        tasks: Wishes = (),
        contacts: Sequence[Contact] = (),
        forces: Forces | None = None,
        loop: LoopSettings | None = None,
    ) -> WholeBodyController:
        """Return a controller of a robot whose base is fixed to the world; see `standing`.

        Level 0 holds the `contacts`, if there are any, level 1 the joint limits; nothing has to be
        balanced, and no wrench of the base to be carried. No floor gives, so the gains are those of
        `LoopSettings(delay=0)` unless a `loop` says otherwise.
        Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
        """
        wish = Wish(tasks, contacts, forces)
        return cls._of(robot, mount(robot, q_start, wish, loop or LoopSettings(delay=0.0)))

    @classmethod
    def _of(cls, robot: Robot, parts: Opened) -> WholeBodyController:
        return cls(
            robot, parts.levels, parts.contacts, parts.settings, parts.q_start,
            wanted_forces=parts.wanted_forces,
        )  # fmt: skip

    # -- putting together -----------------------------------------------------------------------

    def _make_motion(
        self, levels: Sequence[Sequence[Task]], q: Array, fades: dict[str, Fade]
    ) -> MotionGenerator:
        solver_name = self.settings.solver

        def new_solver() -> HierarchySolver:
            return make_solver(solver_name)

        return MotionGenerator(self.robot, levels, new_solver, self.dt, q, fades=fades)

    def _lay_out(self, program: LawProgram) -> None:
        """Put motion and law into one workspace."""
        robot, motion = self.robot, self.motion
        frames = list(
            dict.fromkeys([*motion.program.frames, *map(robot.frame_id, program.contacts.frames())])
        )
        own = motion.program.shapes(len(frames))
        extra = {name: own.pop(name) for name in list(own) if name.startswith(("pairs", "search"))}
        workspace = Workspace(
            {
                "tree": tree_of(robot.model, frames),
                **own,
                "scalars": scalar_shapes(self.wants.scalars),
                **program.shapes(len(frames)),
                "meeting": meeting_shapes(len(self.wants.scalars), robot.na),
                **extra,
            },
            (
                *motion.program.memory,
                *program.memory,
                *(("scalars.numbers",) if self.wants.live else ()),
                *(("meeting.asked_forces",) if motion.program.leans else ()),
            ),
            STAGES,
        )
        fill_tree(workspace.tree, robot.model, frames)

        def number_of(frame: str | int) -> int:
            return frames.index(robot.frame_id(frame))

        motion.program.fill(workspace, number_of)
        program.fill(workspace, number_of)
        fill_scalars(workspace.parts["scalars"], self.wants.scalars, [*self.wants.least.values()])
        motion.work_in(workspace, motion.program, motion.q_ref)
        self.workspace = workspace
        self._blocks = (workspace.floats, workspace.integers, workspace.tables)
        self._write_meeting()

    def _lay_out_again(self, t: float) -> None:
        """Make room for tasks that have other rows than before; only the search's memory goes."""
        motion, before, offsets = self.motion, self.workspace.memory(), self.offsets.copy()
        kin = motion.kinematics(t)
        motion.program = MotionProgram(self.robot, motion.levels, motion.fades, kin, t)
        self._lay_out(self._law_program)
        if self.law is not None:
            self.law.move_into(self.workspace, MEASURED)
        now = self.workspace.memory()
        kept = {
            name: values if name.startswith("search") or values.shape != before[name].shape
            else before[name] for name, values in now.items()
        }  # fmt: skip
        self.workspace.restore(kept)
        self.offsets[:] = offsets
        self._write_supports()
        self._fused = self._runs_in_one_call()
        self._hold(self._held)

    def _runs_in_one_call(self) -> bool:
        return self.law is not None and self.motion.one_call and not self.law.asks_python

    def _make_law(self) -> PassivityController:
        settings = self.settings
        return PassivityController(
            self.robot, self._held, settings.gains, self.dt, bounds=settings.bounds,
            filter_time=settings.filter_time, split=settings.split,
            inside=(self.workspace, self._law_program, MEASURED),
        )  # fmt: skip

    def _write_meeting(self) -> None:
        meeting, limits = self.workspace.parts["meeting"], self.settings.limits
        meeting.numbers[PERIOD] = self.dt
        meeting.numbers[POSTURE_ERROR], meeting.numbers[TILT] = limits.posture_error, limits.tilt
        meeting.flags[FADING] = bool(self.motion.fades)
        meeting.flags[LEANING] = self.motion.program.leans
        if self.settings.governor is not None:
            self.settings.governor.write(self.workspace.parts["tasks"])
        robot = self.robot
        meeting.fastest[:] = limits.overspeed * robot.v_max
        sizes = (robot.nq, robot.nv, robot.na, robot.nv, robot.nv)
        self.ends = tuple(np.cumsum(sizes).tolist())

    def _hold(self, stack: ContactStack) -> None:
        """Note which contacts hold, and what they want."""
        self._held = stack
        self._rows_held = stack.size
        if self.law is None:  # the law holds them itself; a kernel reads from it what is wanted
            self._law_program.hold(self.workspace, stack)
        wanted = self.wants.of(stack)
        self.workspace.parts["meeting"].wanted_of[: len(wanted)] = wanted
        self._wanted_held = wanted
        self._size = self.ends[-1] + stack.supporting_rows.size

    # -- running --------------------------------------------------------------------------------

    @property
    def contacts(self) -> ContactStack:
        """The contacts that hold now."""
        return self._held

    @property
    def clock(self) -> tuple[float, float]:
        """Rate [1] and time [s] of the governor's clock; (1, nan) where nobody slows it."""
        clock = self.workspace.parts["tasks"].clock
        return float(clock[CLOCK_RATE]), float(clock[CLOCK_TIME]) if clock[GOVERNED] else np.nan

    def follows(self, t: float) -> float:
        """Return the time [s] whose targets and contacts are followed in the tick of time `t`."""
        clock = self.workspace.parts["tasks"].clock
        return float(clock[CLOCK_TIME]) if clock[GOVERNED] else t

    def come_to_stand(self, t: float, within: float) -> None:
        """Let all that is wanted slow down and stand still `within` [s], for good: a calm end.

        From time `t` [s] on tasks, contacts and wanted forces are those of a clock that stops.
        Raises: `InputError`.
        """
        bring_to_stand(self.workspace.parts["tasks"], time_of(t), positive("within", within, "s"))

    @property
    def motion_status(self) -> Status:
        """How the last hierarchy was solved."""
        return STATUS_OF[int(self.workspace.parts["tasks"].flags[MOTION_STATUS])]

    @property
    def rows(self) -> dict[str, int]:
        """Of each regulated row, "contact/row", its place in `wanted`."""
        return self.wants.rows

    @property
    def wanted(self) -> Array:
        """The multipliers wanted at the last tick (k,), in the order of `rows`."""
        wanted = self.workspace.parts["scalars"].values[: len(self.wants.scalars)] + self.offsets
        return np.maximum(wanted, self.workspace.parts["scalars"].least[: len(self.wants.scalars)])

    @property
    def asked(self) -> Array:
        """The multipliers that the law was asked for (k,): behind `wanted` while the robot leans.

        Zero for what does not hold. Where no balance task `leans` they are what is wanted.
        """
        parts = self.workspace.parts
        asked = np.zeros(len(self.wants.scalars))
        asked[self._wanted_held] = parts["law"].lam_ref[: len(self._wanted_held)]
        return asked

    @property
    def out_of_reach(self) -> dict[str, float]:
        """By task how far [m] a hand is from a target that it cannot get to, and waits for."""
        return self.motion.out_of_reach

    @property
    def offsets(self) -> Array:
        """What a person adds to the wanted multipliers (k,), in the order of `rows`."""
        return self.workspace.parts["scalars"].offsets[: len(self.wants.scalars)]

    def step(self, t: float, q: Array, v: Array, wrenches: Wrenches) -> WholeBodyCommand:
        """Return the command at time `t` [s] for a measured state.

        `q` (nq,), `v` (nv,); `wrenches` are the multipliers of the contacts that hold, stacked
        (r,) or by the name of the contact. Never raises on values, never exceeds a torque limit.
        Raises: `ShapeError`, `InputError` for what is no array of the right size or no time.
        """
        t = time_of(t)
        self.followed_at = followed = self.follows(t)
        stack = self.supports.at(followed)
        if stack is not self._held:
            self._go_over(stack)
        q, v, lam = self._checked(q, v, wrenches)
        self.motion.stamp += 1
        self.wants.write(self.workspace.parts["scalars"].values, followed)
        if self._fused and self.supervisor.mode is Mode.RUN:
            return self._in_one(t, q, v, lam)
        return self._in_parts(t, q, v, lam)

    def _in_one(self, t: float, q: Array, v: Array, lam: Array) -> WholeBodyCommand:
        result = np.empty(self._size)
        if self.motion.asks_before:
            self.motion.program.write_before(self.workspace, self.followed_at)
        code = tick(*self._blocks, t, q, v, lam, WHOLE, result)
        if code == ASKED:
            self.motion.program.ask_coal(self.workspace)
            code = tick(*self._blocks, t, q, v, lam, WHOLE & ~BEGIN_MOTION, result)
        if code in SUPERVISED:
            return self._supervised(t, q, v, lam, result)
        command = WholeBodyCommand(t, STATUS[code], result, self)
        self.supervisor.saw(t, Measurement(q, v, lam), command.tau)
        return command

    def _in_parts(self, t: float, q: Array, v: Array, lam: Array) -> WholeBodyCommand:
        """Run a tick in which Python has a say: in tasks, solver, contacts, controller or mode."""
        self.motion.solve(self.followed_at)
        result = np.empty(self._size)
        tick(*self._blocks, t, q, v, lam, WANT, result)
        if self.law is None or self.law.asks_python or self.supervisor.mode is not Mode.RUN:
            return self._supervised(t, q, v, lam, result)
        code = tick(*self._blocks, t, q, v, lam, BEGIN_LAW | RUN_LAW | MOVE, result)
        if code in SUPERVISED:
            return self._supervised(t, q, v, lam, result)
        command = WholeBodyCommand(t, STATUS[code], result, self)
        self.supervisor.saw(t, Measurement(q, v, lam), command.tau)
        return command

    def _supervised(
        self, t: float, q: Array, v: Array, lam: Array, result: Array
    ) -> WholeBodyCommand:
        """Let the supervisor run the controller on the reference of the moment, and move on."""
        parts = self.workspace.parts
        q_ref, v_ref = parts["reference"].q.copy(), parts["tasks"].v_ref.copy()
        lam_ref = parts["law"].lam_ref[: len(self._wanted_held)].copy()
        measured, reference = Measurement(q, v, lam), Reference(q_ref, v_ref, lam_ref)
        if self.law is None and self.settings.governor is not None and np.isfinite(q).all():
            parts["law"].dq[:] = pin.difference(self.robot.model, q_ref, q)  # what it slows by
        command = self.supervisor.step(t, measured, reference)
        self._write(result, reference, command)
        tick(*self._blocks, t, q, v, lam, MOVE, result)
        return WholeBodyCommand(t, command.status, result, self)

    def _write(self, result: Array, reference: Reference, command: Command) -> None:
        """Write a command that came about outside of the kernel."""
        result[:] = 0.0
        pieces = (reference.q_ref, reference.v_ref, command.tau, command.u, command.s)
        for end, piece in zip(self.ends, pieces, strict=True):
            result[end - len(piece) : end] = piece
        result[self.ends[-1] :] = command.base_reaction if len(command.base_reaction) else 0.0

    def _checked(self, q: Array, v: Array, wrenches: Wrenches) -> tuple[Array, Array, Array]:
        if isinstance(wrenches, Mapping):
            wrenches = self._stacked(wrenches)
        robot = self.robot
        return (
            _vector("q", q, robot.nq),
            _vector("v", v, robot.nv),
            _vector("wrenches", wrenches, self._rows_held),
        )

    def _stacked(self, wrenches: Mapping[str, Array]) -> Array:
        """Return the multipliers of the contacts that hold, one after the other."""
        stacked, rows = np.empty(self._rows_held), self._held.rows
        for name, where in rows.items():
            if name not in wrenches:
                raise NameNotFoundError("wrench of contact", name, wrenches)
            write_vector(f"the wrench of {name}", wrenches[name], stacked[where])
        return stacked

    def hold(self, t: float, last: WholeBodyCommand) -> WholeBodyCommand:
        """Return the last command again for time `t` [s], while the reference moves on.

        For a tick in which nothing was measured or the controller comes too late.
        Raises: `InputError` for what is no time.
        """
        t = time_of(t)
        self.followed_at = followed = self.follows(t)
        stack = self.supports.at(followed)
        if stack is not self._held:
            self._go_over(stack)
        self.motion.stamp += 1
        self.wants.write(self.workspace.parts["scalars"].values, followed)
        self.motion.solve(followed)
        result = last.result.copy()
        result[: self.ends[0]] = self.workspace.parts["reference"].q
        result[self.ends[0] : self.ends[1]] = self.workspace.parts["tasks"].v_ref
        nothing = np.zeros(0)
        tick(*self._blocks, t, nothing, nothing, nothing, WANT | MOVE, result)
        return WholeBodyCommand(t, last.status, result, self)

    def task(self, name: str) -> Task:
        """Return a task by its name, to set its target. Raises: `NameNotFoundError`."""
        tasks = {task.name: task for level in self.motion.levels for task in level}
        if name not in tasks:
            raise NameNotFoundError("task", name, tasks)
        return tasks[name]

    def want(self, row: str, value: float) -> None:
        """Let a contact press with `value` [N], or [N m], from the next tick on, faded over 0.5 s.

        `row` is "contact/row", or the contact if it has one regulated row. From any thread. Only a
        row whose wanted force was given as a number, or as a `LiveScalar`, can be set.
        Raises: `NameNotFoundError`, `InputError` if it can only push and is wanted to pull.
        """
        self.wants.set(row, value)

    def take_over(self, tau: Array) -> None:
        """Begin from joint torques `tau` (na,) [N m] that are measured now, without a jump.

        Raises: `ShapeError`, `NonFiniteError`.
        """
        self.controller.take_over(tau)

    def switch(
        self,
        supports: Sequence[str],
        keep: Keep = "torque",
        *,
        others: Sequence[str] | None = None,
        anchors: Mapping[str, pin.SE3] | None = None,
    ) -> None:
        """Let these contacts support the base from the next tick on, and no others.

        `supports` are names of supporting contacts, `others` of those that hold besides (None: as
        they do now); within their windows, if they have any. What the torque carried is mapped to
        the contacts that hold then (docs/switching): `keep` the "torque" continuous, or the
        "energy" where a loaded contact was lost. `anchors` tell where soles or points stand now, by
        name; one that comes without stands where the reference has it. The reference holds the feet
        that support, if a `ContactTask` does; a foot that is let go follows its other tasks.
        Wrenches are those of the contacts that hold.
        Raises: `NameNotFoundError`, `InputError` if nothing is left that supports.
        """
        if keep not in KEEPS:
            raise InputError("unknown what is to be kept", given=keep, known=list(KEEPS))
        held, known = self.supports, set(self.supports.free)
        held.require(supports, supporting=True)
        held.require(others or (), supporting=False)
        if self.robot.nv_base and not supports:
            raise InputError(
                "no contact is left to support the base",
                known=held.names(supporting=True),
                remedy="Name at least one that supports",
            )
        free = {name for name in held.names(supporting=True) if name not in supports}
        for name in held.names(supporting=False):
            if (name in known) if others is None else (name not in others):
                free.add(name)
        places = {**self._places_of(known - free), **(anchors or {})}
        before = held.state()
        try:
            for name, T in places.items():
                held.anchor(name, T)
        except InputError:
            held.restore(before)
            raise
        held.let_go(free)
        self._keep = keep
        self._write_supports()

    def _places_of(self, names: Iterable[str]) -> dict[str, pin.SE3]:
        """Return where the reference has the frames of soles and points."""
        kin = self.robot.at(self.workspace.parts["reference"].q.copy())
        found = {}
        for name in names:
            contact = self.supports.contacts[name]
            if isinstance(contact, SoleContact):
                found[name] = kin.placement(contact.frame)
            elif isinstance(contact, PointContact):
                T = kin.placement(contact.frame)
                found[name] = pin.SE3(T.rotation, T.act(np.array(contact.offset)))
        return found

    def _write_supports(self) -> None:
        """Tell law and reference where contacts stand now, and the reference which are let go."""
        parts, motion = self.workspace.parts, self.motion.program
        for contact in self.supports.moved:
            self._law_program.contacts.replace(parts["law_contacts"], contact)
            motion.contacts.replace(parts["contacts"], contact)
        motion.let_go(self.workspace, self.supports.free)

    def _go_over(self, stack: ContactStack) -> None:
        """Let the contacts of a stack hold from this tick on."""
        if self.law is not None:
            self.law.switch(stack, self._keep)
        else:
            self.controller.switch(stack)
        self._keep = "torque"
        self._hold(stack)

    @property
    def story(self) -> tuple[str, ...]:
        """Every change of the mode, and what soles were about to do, in sentences."""
        notes = self.law.notes if self.law is not None else {}
        near = (f"t = {t:.3f} s: {what}, if it goes on like this" for what, t in notes.items())
        changes = (str(change) for change in self.supervisor.changes)
        return (*changes, *self.wants.refused.values(), *near)

    # -- memory ---------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """Return a copy of the whole memory: reference, working sets, law and supervisor."""
        state = {
            "workspace": self.workspace.memory(),
            "supervisor": self.supervisor.state(),
            "held": tuple(self._held.rows),
            "supports": self.supports.state(),
            "keep": self._keep,
        }
        if self.law is None:
            state["controller"] = self.controller.state()
        return state

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a memory that `state` returned: the same inputs then give the same bits.

        Raises: `InputError` for what is no memory of a controller made alike; nothing is changed.
        """
        _require_alike(state, self.state())
        self.supports.restore(state["supports"])
        self._write_supports()
        self._keep = state["keep"]
        stack = self.supports.named(state["held"])
        if self.law is not None:
            self.law.hold(stack)
        self._hold(stack)
        self.workspace.restore(state["workspace"])
        self.supervisor.restore(state["supervisor"])
        if self.law is None:
            self.controller.restore(state["controller"])


def _require_alike(state: object, own: Mapping[str, Any]) -> None:
    """Refuse what is no state like this one: its parts, and the sizes of its arrays."""
    alike = isinstance(state, Mapping) and set(state) == set(own)
    if alike:
        given, mine = state["workspace"], own["workspace"]  # type: ignore[index]
        alike = isinstance(given, Mapping) and set(given) == set(mine)
        alike = alike and all(np.shape(given[name]) == mine[name].shape for name in mine)
    if not alike:
        raise InputError(
            "this is no state of a controller like this one",
            given=type(state).__name__,
            remedy="Give what `state()` returned, of this controller or of one made alike",
        )


def _vector(name: str, values: Any, size: int) -> Array:
    """Return values as the kernels want them, without a copy where they are that already."""
    if type(values) is np.ndarray and values.dtype == np.float64 and values.flags.carray:
        if values.shape != (size,):
            raise ShapeError(name, values.shape, (size,))
        return values
    return real_array(name, values, (size,), finite=False)
