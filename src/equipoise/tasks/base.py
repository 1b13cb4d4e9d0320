"""What every task provides: its rows at a state and a time, and its error in its own unit."""

from __future__ import annotations

from abc import ABC, abstractmethod

from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array


class Task(ABC):
    """Produces rows `lower <= A v <= upper` for the velocity v of the robot.

    A task is immutable; its targets are trajectories given at construction.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return the rows at the state of `kin` and time `t` [s]."""

    @abstractmethod
    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far the task is from being met, in its own unit; positive part = violation.

        For an equality the signed error; for an inequality `max(0, violation)`.
        """

    @property
    @abstractmethod
    def labels(self) -> tuple[str, ...]:
        """Name of each component of `error`."""

    @property
    @abstractmethod
    def units(self) -> tuple[str, ...]:
        """Unit of each component of `error`."""
