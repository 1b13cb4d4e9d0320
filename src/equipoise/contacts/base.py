"""What every contact kind provides: rows, rate, drift, residual, and its regulated rows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from equipoise.contacts.rows import ContactRows
from equipoise.errors import NameNotFoundError
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array

WRENCH_LABELS = ("fx", "fy", "fz", "mx", "my", "mz")
WRENCH_UNITS = ("N", "N", "N", "N m", "N m", "N m")


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

    def fill(self, kin: Kinematics, rows: ContactRows, at: int, *, drift: bool = False) -> None:
        """Write this contact's rows from row `at` on; its drift only if asked for."""
        here = slice(at, at + self.size)
        rows.J[here] = self.jacobian(kin)
        rows.rate[here] = self.rate(kin)
        rows.residual[here] = self.residual(kin)
        if drift:
            rows.drift[here] = self.drift(kin)

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


class RowsContact(Contact):
    """A contact that writes its rows in place by `fill`, from which comes what is asked singly."""

    @abstractmethod
    def fill(self, kin: Kinematics, rows: ContactRows, at: int, *, drift: bool = False) -> None:
        """Write this contact's rows from row `at` on; its drift only if asked for."""

    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J` (k, nv)."""
        return self._alone(kin).J

    def rate(self, kin: Kinematics) -> Array:
        """Return `nu_c` (k,)."""
        return self._alone(kin).rate

    def residual(self, kin: Kinematics) -> Array:
        """Return `phi` (k,)."""
        return self._alone(kin).residual

    def drift(self, kin: Kinematics) -> Array:
        """Return `dJ/dt v - d rate/dt` (k,)."""
        return self._alone(kin, drift=True).drift

    def _alone(self, kin: Kinematics, drift: bool = False) -> ContactRows:
        rows = ContactRows.of_size(self.size, kin.robot.nv)
        self.fill(kin, rows, 0, drift=drift)
        return rows


class CompiledContact(RowsContact):
    """A contact whose rows come from a kernel, together with those of others (`ContactProgram`).

    It says which `kernel`, of which two `frames` (the same twice where it has only one), and what
    it keeps, twelve numbers `kept` as a rule a pose row. It does not move by itself.
    """

    kernel: str

    @property
    @abstractmethod
    def frames(self) -> tuple[int, int]:
        """Ids of the frames that are held."""

    @property
    @abstractmethod
    def kept(self) -> Array:
        """What is kept (12,)."""

    def fill(self, kin: Kinematics, rows: ContactRows, at: int, *, drift: bool = False) -> None:
        """Write this contact's rows from row `at` on; its drift only if asked for."""
        from equipoise.contacts.program import ContactProgram  # it knows all kinds of contacts

        ContactProgram([self], [at]).fill(kin, rows, drift=drift)
