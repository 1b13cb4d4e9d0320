"""Rigid bodies with rigid bilateral contacts, equation (8), by factorising inertia and Delassus.

The contacts hold in both directions with infinite friction, as in the paper; whether a real floor
could have done so is judged elsewhere (`contacts.reaction_margins`).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.linalg import lapack

from equipoise.contacts import ContactStack
from equipoise.errors import EquipoiseError, InputError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics.engine import PhysicsState
from equipoise.robots import Robot
from equipoise.spatial import Array


class DivergedError(EquipoiseError):
    """The simulated state is no longer finite."""


class RigidContactEngine:
    """Semi-implicit Euler on the KKT system of (8) with Baumgarte terms scaled by the step.

    `J a + drift = -(position_gain/h^2) phi - (velocity_gain/h) (J v - nu_c)` with the physics step
    h and the contacts' drift `dJ/dt v - d nu_c/dt`, so that a violation is taken back within some
    ten steps whatever the step is. Redundant rows get a proximal term relative to the Delassus
    matrix.

    Args: `robot` is the true robot (payload, scaled masses); `joint_damping` [N m s/rad] acts
    implicitly, so that no value of it is too stiff for the step;
    `control_dt` [s] is held over `substeps` physics steps.
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
    ) -> None:
        if substeps < 1:
            raise InputError("the physics needs at least one step a control period", given=substeps)
        self.robot, self.contacts = robot, contacts
        self.h = control_dt / substeps
        self.substeps = substeps
        self._position_gain = position_gain / self.h**2
        self._velocity_gain = velocity_gain / self.h
        self._damping = np.concatenate((np.zeros(6), np.full(robot.na, joint_damping)))
        self._diagonal = np.diag_indices(robot.nv)
        self._proximal = proximal
        self._evaluator = KinematicsEvaluator(robot)
        self._dynamics = robot.model.createData()
        self._q = np.array(q_start, dtype=float)
        self._v = np.zeros(robot.nv) if v_start is None else np.array(v_start, dtype=float)
        self._ticks = 0
        self._t = 0.0
        self._control_dt = control_dt
        self._lam = np.zeros(contacts.size)
        self._drift = self._largest_residual()

    @property
    def state(self) -> PhysicsState:
        """The present state."""
        t = self._ticks * self._control_dt
        return PhysicsState(t, self._q.copy(), self._v.copy(), self._lam.copy(), self._drift)

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period with `tau` (na,) [N m] held; return the new state.

        Raises: `DivergedError` if the state is no longer finite.
        """
        force = np.concatenate((np.zeros(6), tau))
        total = np.zeros(self.contacts.size)
        self._drift = 0.0
        for substep in range(self.substeps):
            self._t = self._ticks * self._control_dt + substep * self.h
            a, lam = self.accelerations(force)
            self._v = self._v + self.h * a
            self._q = pin.integrate(self.robot.model, self._q, self._v * self.h)
            total += lam
            if not (np.isfinite(self._q).all() and np.isfinite(self._v).all()):
                raise DivergedError(
                    f"the simulation diverged at t = {self.state.t:.3f} s; lower K_d or the step"
                )
        self._lam = total / self.substeps
        self._ticks += 1
        self._t = self._ticks * self._control_dt
        return self.state

    def accelerations(self, force: Array) -> tuple[Array, Array]:
        """Solve (8) at the present state for `a` (nv,) and `lam` (r,) under `force` (nv,)."""
        model, data = self.robot.model, self._dynamics
        kin = self._evaluator.at(self._q, self._v, self._t)
        M = pin.crba(model, data, self._q).T  # lower triangle
        M[self._diagonal] += self.h * self._damping
        L, _ = lapack.dpotrf(M, lower=1)
        bias = pin.nonLinearEffects(model, data, self._q, self._v)
        free = force - bias - self._damping * self._v
        if not self.contacts.size:
            a, _ = lapack.dpotrs(L, free, lower=1)
            return a, np.zeros(0)
        J = self.contacts.jacobian(kin)
        phi = self.contacts.residual(kin)
        self._drift = max(self._drift, float(np.abs(phi).max()))
        wanted = (
            -self.contacts.drift(kin)
            - self._position_gain * phi
            - self._velocity_gain * (J @ self._v - self.contacts.rate(kin))
        )
        half, _ = lapack.dtrtrs(L, J.T, lower=1)
        half_free, _ = lapack.dtrtrs(L, free, lower=1)
        lam = self._multiplier(half.T @ half, wanted - half.T @ half_free)
        a, _ = lapack.dtrtrs(L, half_free + half @ lam, lower=1, trans=1)
        return a, lam

    def _multiplier(self, delassus: Array, rhs: Array) -> Array:
        scale = self._proximal * np.trace(delassus) / len(rhs)
        regular = delassus + scale * np.eye(len(rhs))
        factor, info = lapack.dpotrf(regular, lower=1)
        if info != 0:
            return np.linalg.lstsq(delassus, rhs, rcond=1e-12)[0]
        lam, _ = lapack.dpotrs(factor, rhs, lower=1)
        correction, _ = lapack.dpotrs(factor, rhs - delassus @ lam, lower=1)
        return lam + correction

    def _largest_residual(self) -> float:
        if not self.contacts.size:
            return 0.0
        phi = self.contacts.residual(self._evaluator.at(self._q, self._v, self._t))
        return float(np.abs(phi).max())
