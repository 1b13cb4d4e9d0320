"""What every contact kind provides: rows, rate, drift, residual, and its regulated rows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from equipoise.compiled.workspace import Workspace
from equipoise.contacts.view import GIVEN, NUMBERS
from equipoise.errors import NameNotFoundError
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array

WRENCH_LABELS = ("fx", "fy", "fz", "mx", "my", "mz")
WRENCH_UNITS = ("N", "N", "N", "N m", "N m", "N m")
ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Contact(ABC):
    """A holonomic constraint `phi(q, t) = 0` with multiplier `lam`, world on robot.

    `name` names it in logs and errors. `supporting`: it may carry any reaction and takes part in
    carrying the base. `regulated`: labels of the rows whose multiplier follows a wanted profile.

    Source: eq. (13). Differs from the print: none.
    """

    name: str
    supporting: bool = False
    regulated: tuple[str, ...] = ()
    kind: ClassVar[int] = GIVEN

    def __post_init__(self) -> None:
        for label in self.regulated:
            if label not in self.labels:
                raise NameNotFoundError(f"row of contact {self.name!r} named", label, self.labels)

    @property
    @abstractmethod
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""

    @property
    @abstractmethod
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""

    @abstractmethod
    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J` (k, nv): the rows `J v = rate`."""

    def rate(self, kin: Kinematics) -> Array:
        """Return `nu_c` (k,), the right-hand side of `J v = nu_c`: zero unless it moves itself."""
        return np.zeros(self.size)

    @abstractmethod
    def drift(self, kin: Kinematics) -> Array:
        """Return `dJ/dt v - d rate/dt` (k,): the rows' second derivative is `J dv/dt + drift`."""

    @abstractmethod
    def residual(self, kin: Kinematics) -> Array:
        """Return `phi` (k,), with `d phi / dt = J v - rate` where `phi` is small."""

    @property
    def one_sided(self) -> frozenset[str]:
        """Labels of the rows whose multiplier is a pressure: it pushes and cannot pull."""
        return frozenset() if self.normal_row is None else frozenset({self.labels[self.normal_row]})

    @property
    def normal_row(self) -> int | None:
        """Number of the row whose multiplier is the compression [N], if there is one."""
        return None

    def reaction_costs(self) -> tuple[Array, Array]:
        """Return what a unit of each row's multiplier costs when the base is carried.

        Two arrays (k,): a constant part, and one that is divided by the contact's load, its normal
        force as a share of the mean of all that support.
        """
        return np.ones(self.size), np.zeros(self.size)

    @property
    def size(self) -> int:
        """Number of rows."""
        return len(self.labels)


@dataclass(frozen=True)
class KernelContact(Contact):
    """A contact whose rows come from kernels, `kind` telling `program` which.

    It says of which two `frames` (the same twice where it has only one), and its `numbers`.
    `alone` calls its kernels for one contact, made by `alone_of`.
    """

    alone: ClassVar[Callable[..., None]]

    @property
    @abstractmethod
    def frames(self) -> tuple[str | int, str | int]:
        """Names or ids of the frames that are held."""

    @property
    @abstractmethod
    def numbers(self) -> Array:
        """The constants that its kernels need, at most `NUMBERS`."""

    @property
    def surface_kind(self) -> int:
        """Which surface it slides on, as kernels know it; zero for none."""
        return 0

    def place(self, t: float) -> Array:
        """Return where its surface is and how it moves at time `t` [s] (24,); zeros without one."""
        return np.zeros(24)

    def sample(self, kin: Kinematics) -> Array:
        """Return value, gradient and Hessian (13,) of a surface of one's own at the contact."""
        return np.zeros(13)

    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J` (k, nv)."""
        return self._alone(kin)[0]

    def rate(self, kin: Kinematics) -> Array:
        """Return `nu_c` (k,)."""
        return self._alone(kin)[1][1]

    def residual(self, kin: Kinematics) -> Array:
        """Return `phi` (k,)."""
        return self._alone(kin)[1][0]

    def drift(self, kin: Kinematics) -> Array:
        """Return `dJ/dt v - d rate/dt` (k,)."""
        return self._alone(kin)[1][2]

    def _alone(self, kin: Kinematics) -> tuple[Array, Array]:
        """Return `J` (k, nv), and residual, rate and drift (3, k)."""
        workspace: Workspace = kin.with_frames(self.frames)
        J, others = np.zeros((self.size, kin.robot.nv)), np.zeros((3, self.size))
        numbers = np.zeros(NUMBERS)
        numbers[: len(self.numbers)] = self.numbers
        type(self).alone(
            workspace.floats, workspace.integers, workspace.tables, numbers, self.place(kin.t),
            self.sample(kin), self.surface_kind, J, others,
        )  # fmt: skip
        return J, others
