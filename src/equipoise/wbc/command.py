"""What a tick gives: torque, reference, and how both came about."""

from __future__ import annotations

from typing import Protocol

from equipoise.control import ControlStatus, Supervisor
from equipoise.hqp import Hierarchy, Solution, Status
from equipoise.motion import MotionGenerator
from equipoise.spatial import Array


class Owner(Protocol):
    """The controller whose tick it was."""

    supervisor: Supervisor
    motion: MotionGenerator
    ends: tuple[int, ...]  # of the parts of `result`

    @property
    def motion_status(self) -> Status:
        """How the hierarchy was solved."""


class WholeBodyCommand:
    """What a tick gives: `tau` (na,) [N m], the reference it was for, and how it came about.

    `q_ref` (nq,), `v_ref` (nv,): the reference of this moment. `status` of the law, `mode` of the
    supervisor. `u` (nv,), `s` (nv,), `base_reaction` (k,) as in `Command`, empty where the
    controller has none. The hierarchy and its solution are put together when they are asked for,
    which has to be before the next tick.
    """

    __slots__ = ("_ends", "_owner", "_stamp", "mode", "result", "status", "t")

    def __init__(self, t: float, status: ControlStatus, result: Array, owner: Owner) -> None:
        self.t, self.status, self.result, self._owner = t, status, result, owner
        self.mode, self._ends, self._stamp = owner.supervisor.mode, owner.ends, owner.motion.stamp

    @property
    def q_ref(self) -> Array:
        """The reference configuration (nq,)."""
        return self.result[: self._ends[0]]

    @property
    def v_ref(self) -> Array:
        """The reference velocity (nv,)."""
        return self.result[self._ends[0] : self._ends[1]]

    @property
    def tau(self) -> Array:
        """The torque (na,) [N m]."""
        return self.result[self._ends[1] : self._ends[2]]

    @property
    def u(self) -> Array:
        """The fully actuated law (nv,)."""
        return self.result[self._ends[2] : self._ends[3]]

    @property
    def s(self) -> Array:
        """The extended error (nv,)."""
        return self.result[self._ends[3] : self._ends[4]]

    @property
    def base_reaction(self) -> Array:
        """The change F (k,) of the supporting reactions."""
        return self.result[self._ends[4] :]

    @property
    def motion_status(self) -> Status:
        """How the hierarchy was solved, as far as the solver knows."""
        return self._owner.motion_status

    @property
    def hierarchy(self) -> Hierarchy:
        """The hierarchy of this tick."""
        return self._solved()[0]

    @property
    def solution(self) -> Solution:
        """Its solution."""
        return self._solved()[1]

    def _solved(self) -> tuple[Hierarchy, Solution]:
        self._owner.motion.require(self._stamp)
        return self._owner.motion.solved()
