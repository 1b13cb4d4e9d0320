"""Rigid bodies with rigid bilateral contacts, equation (8), by factorising inertia and Delassus.

The contacts hold in both directions with infinite friction, as in the paper; whether a real floor
could have done so is judged elsewhere (`contacts.wrench_cone`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled.workspace import Workspace
from equipoise.contacts import ContactStack
from equipoise.contacts.program import ContactProgram
from equipoise.errors import InputError
from equipoise.kinematics.kernels import state_of
from equipoise.kinematics.state import Kinematics, KinematicsMemory
from equipoise.kinematics.tree import fill_tree, tree_of
from equipoise.physics.engine import DivergedError, PhysicsState, checked_torque
from equipoise.physics.no_objects import NoObjects
from equipoise.physics.pushed_object import PushedObject, PushedObjectMode, PushedObjectState
from equipoise.physics.rigid.kernels import accelerate, look, solve
from equipoise.physics.rigid.memory import SINGULAR, SLIP, VIOLATION, dynamics_shapes
from equipoise.robots import Robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, real_period, real_vector

PLACE, ROWS = 1, 2
_MODES = (PushedObjectMode.FREE, PushedObjectMode.STICK, PushedObjectMode.SLIP)


@dataclass(frozen=True)
class RigidOptions:
    """How the engine steps.

    `substeps` physics steps a control period; `position_gain` and `velocity_gain`, as shares a
    step, draw contacts back; `joint_damping` [N m s/rad] acts implicitly, so that no value of it is
    too stiff for the step; `proximal` keeps the rows of redundant contacts apart.
    """

    substeps: int = 1
    position_gain: float = 0.1
    velocity_gain: float = 0.7
    joint_damping: float = 0.0
    proximal: float = 1e-12

    def __post_init__(self) -> None:
        if self.substeps < 1:
            raise InputError(
                "the physics needs at least one step a control period", given=self.substeps
            )
        for name in ("position_gain", "velocity_gain", "joint_damping", "proximal"):
            not_negative(name, getattr(self, name))


class RigidContactEngine(NoObjects):
    """Semi-implicit Euler on the KKT system of (8) with Baumgarte terms scaled by the step.

    `J a + drift = -(position_gain/h^2) phi - (velocity_gain/h) (J v - nu_c)` with the physics step
    h and the contacts' drift `dJ/dt v - d nu_c/dt`, so that a violation is taken back within some
    ten steps whatever the step is. Redundant rows get a proximal term relative to the Delassus
    matrix.

    Args: `robot` is the plant (payload, scaled masses); `control_dt` [s] is held over the
    `substeps` of the `options`. `pushed` are objects behind one-row contacts, which then only push
    (see `PushedObject`); `one_sided` names other one-row contacts that only push, against what
    never gives way. The rows of `lam` of both are zero while free.
    Source: eq. (8). Differs from the print: second row `dJ/dt v - d nu_c/dt` (the dot is missing),
    torque on the actuated rows only, stabilised.
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
        one_sided: Sequence[str] = (),
    ) -> None:
        options = options or RigidOptions()
        control_dt = real_period("the control period", control_dt)
        self.robot, self.contacts = robot, contacts
        self.h, self.substeps = control_dt / options.substeps, options.substeps
        self.sliders = {one: PushedObjectState() for one in pushed}
        self._program = ContactProgram(contacts.contacts)
        self._lay_out(options.joint_damping, one_sided)
        position_gain, velocity_gain = options.position_gain, options.velocity_gain
        self._work.settings[:4] = (
            self.h, position_gain / self.h**2, velocity_gain / self.h, options.proximal
        )  # fmt: skip
        self._dynamics = JointDynamics(robot.model)
        self._state.q[:] = real_vector("q_start", q_start, robot.nq)
        if v_start is not None:
            self._state.v[:] = real_vector("v_start", v_start, robot.nv)
        self._ticks, self._t, self._control_dt = 0, 0.0, control_dt
        self._lam = np.zeros(contacts.size)
        self.external = np.zeros(robot.nv)  # generalised force of whoever pushes, held in `step`
        self._look()
        self._violation = float(self._work.settings[VIOLATION])

    def _lay_out(self, joint_damping: float, one_sided: Sequence[str]) -> None:
        robot, program, contacts = self.robot, self._program, self.contacts
        frames = list(dict.fromkeys(map(robot.frame_id, program.frames())))
        workspace = Workspace(
            {
                "tree": tree_of(robot.model, frames),
                "state": state_of(robot.model, len(frames)),
                "contacts": program.shapes(),
                "work": dynamics_shapes(
                    contacts.size,
                    robot.nv,
                    len(contacts.contacts),
                    len(self.sliders) + len(one_sided),
                ),
            }
        )
        fill_tree(workspace.tree, robot.model, frames)
        program.fill(workspace.contacts, lambda frame: frames.index(robot.frame_id(frame)))
        work = self._work = workspace.work
        work.at[: len(contacts.contacts)] = program.starts[:-1]
        work.damping[robot.nv_base :] = joint_damping
        work.bilateral[: contacts.size], work.pushed[:] = 1, -1
        for i, slider in enumerate(self.sliders):
            row = contacts.rows[slider.contact].start
            work.pushed[i], work.bilateral[row] = row, 0
            work.coulomb[i], work.viscosity[i] = slider.coulomb, slider.viscosity
        for i, name in enumerate(one_sided, len(self.sliders)):
            row = contacts.rows[name].start
            work.pushed[i], work.bilateral[row] = row, 0
            work.coulomb[i], work.viscosity[i] = math.inf, 1.0
        self._state, self._contacts = workspace.state, workspace.contacts
        self._entrance = (workspace.floats, workspace.integers, workspace.tables)
        self._memory = KinematicsMemory(robot, workspace, 1)

    def begin_at(self, ticks: int) -> None:
        """Let so many control periods have gone by before the next step."""
        self._ticks, self._t = ticks, ticks * self._control_dt

    @property
    def state(self) -> PhysicsState:
        """The present state."""
        t = self._ticks * self._control_dt
        return PhysicsState(
            t, self._state.q.copy(), self._state.v.copy(), self._lam.copy(), self._violation
        )

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period with `tau` (na,) [N m] held; return the new state.

        Raises: `InputError` for what is no finite torque, before anything moves; `DivergedError` if
        the state is no longer finite; it then stays what it was.
        """
        tau = checked_torque(tau, self.robot.na)
        work, base, state = self._work, self.robot.nv_base, self._state
        last = state.q.copy(), state.v.copy()
        work.force[:] = self.external
        work.force[base:] += tau
        work.total[:] = 0.0
        work.settings[VIOLATION] = 0.0
        for substep in range(self.substeps):
            self._t = self._ticks * self._control_dt + substep * self.h
            self._look()
            self._solve()
            if not math.isfinite(accelerate(*self._entrance, True)):
                state.q[:], state.v[:] = last
                raise DivergedError(
                    f"the simulation diverged at t = {self._t:.3f} s; lower K_d or the step"
                )
            self._move_pushed()
        self._violation = float(work.settings[VIOLATION])
        self._lam = work.total[: self.contacts.size] / self.substeps
        self._ticks += 1
        self._t = self._ticks * self._control_dt
        return self.state

    def stand(self) -> Array:
        """Let the plant stand at rest where it is; return the torque (na,) [N m] for it.

        What joint torque sensors read on a robot that stands under its servos: the least reaction
        of the supporting contacts carries the base, nothing else is touched. That reaction is then
        what is measured before the first step.
        """
        robot, base = self.robot, self.robot.nv_base
        gravity = self._dynamics.gravity(self._state.q)
        rows = self.contacts.supporting_rows
        J = self.contacts.jacobian(robot.at(self._state.q, None, self._t))[rows]
        lam = np.linalg.lstsq(J[:, :base].T, gravity[:base], rcond=None)[0]
        self._lam[rows] = lam
        return (gravity - J.T @ lam)[base:]

    def weigh(self, robot: Robot) -> None:
        """Let every link weigh what it does in `robot`, a copy of this one, from now on."""
        self.robot, self._dynamics = robot, JointDynamics(robot.model)

    def support(self, name: str, T_world_anchor: pin.SE3 | None) -> None:
        """Raise: `InputError`. These contacts hold both ways, for as long as the run lasts."""
        raise InputError(
            f"contact {name!r} cannot be lifted or put down: the contacts of this engine hold",
            remedy="Use the engine mujoco, or rigid with contacts that lift",
        )

    def remove(self, name: str) -> None:
        """Raise: `InputError`. Nothing stands on bodies of the world here."""
        raise InputError(
            f"the body {name!r} cannot vanish: the contacts of this engine hold",
            remedy="Use the engine mujoco, or rigid with contacts that lift",
        )

    def accelerations(self, force: Array) -> tuple[Array, Array]:
        """Solve (8) at the present state for `a` (nv,) and `lam` (r,) under `force` (nv,)."""
        work = self._work
        work.force[:] = force
        self._look()
        self._solve()
        accelerate(*self._entrance, False)
        return work.a.copy(), work.lam[: self.contacts.size].copy()

    def _look(self) -> None:
        """Place everything at the present state and write the rows of the contacts."""
        program = self._program
        if program.placed:
            program.write_places(self._contacts, self._t)
        if not program.needs_python:
            look(*self._entrance, self._t, PLACE | ROWS)
            return
        look(*self._entrance, self._t, PLACE)
        kin = self._kinematics()
        program.write_plain(self._contacts, kin, self._work.J, self._work.at.tolist())
        program.write_plain_drifts(self._contacts, kin)
        look(*self._entrance, self._t, ROWS)

    def _kinematics(self) -> Kinematics:
        self._memory.stamp += 1
        return Kinematics(self._memory, self._t)

    def _solve(self) -> None:
        """Solve (8) for the multipliers under the force that stands in the workspace."""
        dynamics, state, work = self._dynamics, self._state, self._work
        M = dynamics.inertia(state.q)
        bias = dynamics.bias(state.q, state.v)
        solve(*self._entrance, M, bias)
        if work.outcome[0] == SINGULAR:
            kept = np.flatnonzero(work.active)
            part = work.delassus[np.ix_(kept, kept)] + np.diag(work.compliance[kept])
            work.lam[:] = 0.0
            work.lam[kept] = np.linalg.lstsq(part, work.rhs[kept], rcond=1e-12)[0]

    def _move_pushed(self) -> None:
        """Advance each pushed object that slips by what its hand advanced."""
        if not self.sliders:
            return
        work = self._work
        if (work.mode == SLIP).any():
            residual = self.contacts.residual(self.robot.at(self._state.q, self._state.v, self._t))
            for i in np.flatnonzero(work.mode == SLIP).tolist():
                work.travel[i] = max(work.travel[i], -float(residual[work.pushed[i]]))
        for i, state in enumerate(self.sliders.values()):
            state.mode, state.travel = _MODES[work.mode[i]], float(work.travel[i])
