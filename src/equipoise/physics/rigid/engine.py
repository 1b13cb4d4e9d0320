"""Rigid bodies with rigid bilateral contacts, equation (8), by factorising inertia and Delassus.

The contacts hold in both directions with infinite friction, as in the paper; whether a real floor
could have done so is judged elsewhere (`contacts.reaction_margins`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactRows, ContactStack
from equipoise.errors import EquipoiseError, InputError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics.engine import PhysicsState
from equipoise.physics.pushed_object import PushedObject, PushedObjectMode, PushedObjectState
from equipoise.physics.rigid.kernels import (
    accelerations_of,
    largest_of,
    multipliers,
    reduce_to_contacts,
)
from equipoise.robots import Robot
from equipoise.spatial import Array


class DivergedError(EquipoiseError):
    """The simulated state is no longer finite."""


class _Room:
    """Memory for one solution of (8), see `reduce_to_contacts`."""

    def __init__(self, r: int, nv: int) -> None:
        self.rows = ContactRows.of_size(r, nv)
        self.L, self.half, self.half_free = np.zeros((nv, nv)), np.zeros((r, nv)), np.zeros(nv)
        self.delassus = np.zeros((r, r))
        self.slip_speed, self.a_free, self.rhs = np.zeros(r), np.zeros(r), np.zeros(r)


class RigidContactEngine:
    """Semi-implicit Euler on the KKT system of (8) with Baumgarte terms scaled by the step.

    `J a + drift = -(position_gain/h^2) phi - (velocity_gain/h) (J v - nu_c)` with the physics step
    h and the contacts' drift `dJ/dt v - d nu_c/dt`, so that a violation is taken back within some
    ten steps whatever the step is. Redundant rows get a proximal term relative to the Delassus
    matrix.

    Args: `robot` is the true robot (payload, scaled masses); `joint_damping` [N m s/rad] acts
    implicitly, so that no value of it is too stiff for the step;
    `control_dt` [s] is held over `substeps` physics steps. `sliders` are objects behind one-row
    contacts, which then only push (see `PushedObject`); their rows of `lam` are zero while free.
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
        v_start: Array | None = None,
        substeps: int = 1,
        position_gain: float = 0.1,
        velocity_gain: float = 0.7,
        joint_damping: float = 0.0,
        proximal: float = 1e-12,
        sliders: Sequence[PushedObject] = (),
    ) -> None:
        if substeps < 1:
            raise InputError("the physics needs at least one step a control period", given=substeps)
        self.robot, self.contacts = robot, contacts
        self.h = control_dt / substeps
        self.substeps = substeps
        self._position_gain = position_gain / self.h**2
        self._velocity_gain = velocity_gain / self.h
        self._damping = np.concatenate((np.zeros(6), np.full(robot.na, joint_damping)))
        self._room = _Room(contacts.size, robot.nv)
        self._proximal = proximal
        self.sliders = {slider: PushedObjectState() for slider in sliders}
        self._slider_rows = [(slider, contacts.rows[slider.contact].start) for slider in sliders]
        pushed = {row for _, row in self._slider_rows}
        self._bilateral = np.array([r for r in range(contacts.size) if r not in pushed], dtype=int)
        self._evaluator = KinematicsEvaluator(robot)
        self._dynamics = robot.model.createData()
        self._q = np.array(q_start, dtype=float)
        self._v = np.zeros(robot.nv) if v_start is None else np.array(v_start, dtype=float)
        self._ticks = 0
        self._t = 0.0
        self._control_dt = control_dt
        self._lam = np.zeros(contacts.size)
        self.external = np.zeros(robot.nv)  # generalised force of whoever pushes, held in `step`
        self._violation = self._largest_residual()

    @property
    def state(self) -> PhysicsState:
        """The present state."""
        t = self._ticks * self._control_dt
        return PhysicsState(t, self._q.copy(), self._v.copy(), self._lam.copy(), self._violation)

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period with `tau` (na,) [N m] held; return the new state.

        Raises: `DivergedError` if the state is no longer finite.
        """
        force = np.concatenate((np.zeros(6), tau)) + self.external
        total = np.zeros(self.contacts.size)
        self._violation = 0.0
        for substep in range(self.substeps):
            self._t = self._ticks * self._control_dt + substep * self.h
            a, lam = self.accelerations(force)
            self._v = self._v + self.h * a
            self._q = pin.integrate(self.robot.model, self._q, self._v * self.h)
            self._move_sliders()
            total += lam
            if not math.isfinite(self._q.sum() + self._v.sum()):
                raise DivergedError(
                    f"the simulation diverged at t = {self.state.t:.3f} s; lower K_d or the step"
                )
        self._lam = total / self.substeps
        self._ticks += 1
        self._t = self._ticks * self._control_dt
        return self.state

    def stand(self) -> Array:
        """Let the true robot stand at rest where it is; return the torque (na,) [N m] for it.

        What joint torque sensors read on a robot that stands under its servos: the least reaction
        of the supporting contacts carries the base, nothing else is touched. That reaction is then
        what is measured before the first step.
        """
        still = np.zeros(self.robot.nv)
        gravity = pin.rnea(self.robot.model, self._dynamics, self._q, still, still)
        rows = self.contacts.supporting_rows
        J = self.contacts.jacobian(self._evaluator.at(self._q, still, self._t))[rows]
        lam = np.linalg.lstsq(J[:, :6].T, gravity[:6], rcond=None)[0]
        self._lam[rows] = lam
        return (gravity - J.T @ lam)[6:]

    def accelerations(self, force: Array) -> tuple[Array, Array]:
        """Solve (8) at the present state for `a` (nv,) and `lam` (r,) under `force` (nv,)."""
        model, data, room = self.robot.model, self._dynamics, self._room
        rows = room.rows
        kin = self._evaluator.at(self._q, self._v, self._t)
        self.contacts.fill(kin, rows, drift=True)
        for slider, row in self._slider_rows:
            rows.residual[row] += self.sliders[slider].travel  # the face moves away
        if self._bilateral.size:
            self._violation = max(self._violation, largest_of(rows.residual, self._bilateral))
        reduce_to_contacts(
            pin.crba(model, data, self._q).T,  # Pinocchio fills the upper half
            self._damping,
            self.h,
            force,
            pin.nonLinearEffects(model, data, self._q, self._v),
            self._v,
            rows.J,
            rows.rate,
            rows.residual,
            rows.drift,
            self._position_gain,
            self._velocity_gain,
            room.L,
            room.half,
            room.half_free,
            room.delassus,
            room.slip_speed,
            room.a_free,
            room.rhs,
        )
        lam = self._multipliers(room)
        a = np.empty(self.robot.nv)
        accelerations_of(room.L, room.half, room.half_free, lam, a)
        return a, lam

    def _multipliers(self, room: _Room) -> Array:
        """Return `lam` (r,): bilateral rows by (8), each slider in the mode that explains it."""
        phi, rhs = room.rows.residual, room.rhs
        active, compliance = np.ones(len(rhs), dtype=bool), np.zeros(len(rhs))
        for slider, row in self._slider_rows:
            state = self.sliders[slider]
            # Touching begins where the gap closes and ends where the hand would have to pull.
            touching = state.mode is not PushedObjectMode.FREE or phi[row] <= 0.0
            state.mode = PushedObjectMode.STICK if touching else PushedObjectMode.FREE
            active[row] = touching
        lam = self._solve(room, active, compliance)
        for slider, row in self._slider_rows:
            state = self.sliders[slider]
            if state.mode is PushedObjectMode.STICK and lam[row] < 0.0:
                state.mode, active[row] = PushedObjectMode.FREE, False
            elif state.mode is PushedObjectMode.STICK and lam[row] > slider.coulomb:
                # v + h a = -(lam - coulomb) / viscosity, implicit in the viscous force
                state.mode = PushedObjectMode.SLIP
                compliance[row] = 1.0 / (slider.viscosity * self.h)
                rhs[row] = (
                    slider.coulomb / (slider.viscosity * self.h)
                    - room.slip_speed[row] / self.h
                    - room.a_free[row]
                )
            else:
                continue
            lam = self._solve(room, active, compliance)
        return lam

    def _solve(self, room: _Room, active: Array, compliance: Array) -> Array:
        lam = np.zeros(len(room.rhs))
        kept = np.empty(len(room.rhs), dtype=np.int64)
        if not multipliers(room.delassus, room.rhs, active, compliance, self._proximal, kept, lam):
            kept = np.flatnonzero(active)
            part = room.delassus[np.ix_(kept, kept)] + np.diag(compliance[kept])
            lam[kept] = np.linalg.lstsq(part, room.rhs[kept], rcond=1e-12)[0]
        return lam

    def _move_sliders(self) -> None:
        """Advance each slider that slips by what its hand advanced."""
        if not self._slider_rows:
            return
        kin = self._evaluator.at(self._q, self._v, self._t)
        for slider, row in self._slider_rows:
            state = self.sliders[slider]
            if state.mode is PushedObjectMode.SLIP:
                reached = -self.contacts.residual(kin)[row]
                state.travel = max(state.travel, float(reached))

    def _largest_residual(self) -> float:
        if not self._bilateral.size:
            return 0.0
        phi = self.contacts.residual(self._evaluator.at(self._q, self._v, self._t))
        return float(np.abs(phi[self._bilateral]).max())
