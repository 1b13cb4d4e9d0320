"""What the driver of a study asks of an engine, and what it is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from equipoise.errors import EquipoiseError
from equipoise.studies.batch import Batch
from equipoise.studies.journal import Result


class DiskFullError(EquipoiseError):
    """A worker could not write what it had found."""


class EngineLostError(EquipoiseError):
    """The engine is gone, or has no workers that stay alive."""


@dataclass(frozen=True)
class Told:
    """Results of a batch; `kept` if they are written already, `over` if it gives no more."""

    batch: Batch
    results: tuple[Result, ...] = ()
    kept: bool = True
    over: bool = False
    lost: bool = False  # its worker ended; what it has no result of is still to be done


class Engine(Protocol):
    """Takes batches, tells results; used by one thread."""

    @property
    def slots(self) -> int:
        """How many batches can be worked on at the same time now."""

    @property
    def waiting_most(self) -> float:
        """How many batches a slot should have, with the one it works on."""

    def submit(self, batch: Batch) -> None:
        """Have a batch done as soon as a slot is free."""

    def wait(self, seconds: float) -> list[Told]:
        """Return what happened; wait for so long if nothing did.

        Raises: `DiskFullError`, `EngineLostError`.
        """

    def close(self) -> None:
        """End what runs, at once."""
