"""Phases of a contact: what was planned of it against what its force says, with hysteresis."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from equipoise.contacts.base import Contact
from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, positive


class Phase(Enum):
    """How a contact is; the value is a sentence."""

    HELD = "it carries, as planned"
    FREE = "it is in the air, as planned"
    TOUCHED = "it touches, but is planned to be in the air or was not loaded yet"
    LATE = "it is planned to carry, and has not touched yet"
    LOST = "it is planned to carry, did so, and does no more"

    @property
    def code(self) -> float:
        """The number that is logged of it: their order."""
        return float(list(Phase).index(self))


@dataclass(frozen=True)
class PhaseSettings:
    """When a contact counts as carrying.

    It begins with a load above `touch` [N] and ends with one below `release` [N], each for `dwell`
    [s] without a break. `patience` [s]: how long it may take to do what has just been planned; it
    is in the phase before meanwhile. It is loaded once its load was above `loaded` [N] (None: that
    of a touch) for `steady` [s]: before, it may come off again, and is not lost.
    Raises: `InputError`.
    """

    touch: float
    release: float
    dwell: float = 0.002
    patience: float = 0.0
    loaded: float | None = None
    steady: float = 0.0

    def __post_init__(self) -> None:
        positive("the load that tells a touch", self.touch)
        not_negative("the load that tells a release", self.release)
        not_negative("the dwell of a phase", self.dwell)
        not_negative("the patience with a phase", self.patience)
        not_negative("how long a contact has to be loaded", self.steady)
        if self.loaded is not None and not self.loaded >= self.touch:
            raise InputError(
                "a contact is loaded by no less than it is touched with",
                given=(self.loaded, self.touch),
            )
        if not self.release < self.touch:
            raise InputError(
                "a contact must be released at a smaller load than it is touched with",
                given=(self.release, self.touch),
            )

    @classmethod
    def for_weight(cls, weight: float, patience: float = 0.0) -> PhaseSettings:
        """Return settings for a robot of a `weight` [N]: 3 % of it touches, 0.5 % releases.

        10 % for 40 ms load: a foot that bounces has 40 % for 15 ms.
        """
        touch, loaded = 0.03 * positive("the weight", weight), 0.1 * weight
        return cls(touch, 0.005 * weight, patience=patience, loaded=loaded, steady=0.04)


@dataclass(frozen=True)
class PhaseChange:
    """At time `t` [s] the contact `name` came into a phase with a `load` [N]."""

    t: float
    name: str
    phase: Phase
    load: float

    def __str__(self) -> str:
        return f"t = {self.t:.3f} s: {self.name}: {self.phase.value} ({self.load:.0f} N)"


class ContactPhases:
    """Follows the phases of contacts: `update` once a tick; `changes` is their story.

    At first what is planned to carry does so.
    """

    def __init__(
        self, contacts: Sequence[Contact], planned: Collection[str], settings: PhaseSettings
    ) -> None:
        self.settings = settings
        self._contacts = {contact.name: contact for contact in contacts}
        self._carries = {name: name in planned for name in self._contacts}
        self._touched = dict(self._carries)  # since it was planned to carry
        self._loaded = dict(self._carries)  # since it was planned to carry
        self._heavy: dict[str, float | None] = dict.fromkeys(self._contacts)  # since when
        self._since: dict[str, float | None] = dict.fromkeys(self._contacts)
        self._planned = {name: name in planned for name in self._contacts}
        self._asked: dict[str, float | None] = dict.fromkeys(self._contacts)  # until it is done
        self.phases = {name: self._phase(name, name in planned) for name in self._contacts}
        self.changes: list[PhaseChange] = []

    @property
    def carrying(self) -> tuple[str, ...]:
        """Names of the contacts that carry."""
        return tuple(name for name, carries in self._carries.items() if carries)

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the contacts that are planned to carry and do not, behind all patience."""
        return tuple(
            name for name, planned in self._planned.items()
            if planned and not self._carries[name] and self._asked[name] is None
        )  # fmt: skip

    def those(self, phase: Phase) -> tuple[str, ...]:
        """Return the names of the contacts in a phase."""
        return tuple(name for name, one in self.phases.items() if one is phase)

    def update(
        self, t: float, planned: Collection[str], lam: Mapping[str, Array]
    ) -> dict[str, Phase]:
        """Take what is planned to carry at time `t` [s] and the multipliers; return the phases.

        `lam` holds the multipliers (k,) of each contact, those that do not hold included; a load
        that is no number changes nothing.
        """
        for name, contact in self._contacts.items():
            load = load_of(contact, lam[name])
            self._look(t, name, load)
            self._wait(t, name, name in planned)
            self._remember(t, name, name in planned, load)
            phase = self._phase(name, name in planned)
            if phase is not self.phases[name]:
                self.phases[name] = phase
                self.changes.append(PhaseChange(t, name, phase, load))
        return dict(self.phases)

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory."""
        return {
            "carries": dict(self._carries),
            "touched": dict(self._touched),
            "loaded": dict(self._loaded),
            "heavy": dict(self._heavy),
            "since": dict(self._since),
            "planned": dict(self._planned),
            "asked": dict(self._asked),
            "phases": dict(self.phases),
            "changes": list(self.changes),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state` returned."""
        self._carries, self._touched = dict(state["carries"]), dict(state["touched"])
        self._loaded, self._heavy = dict(state["loaded"]), dict(state["heavy"])
        self._since, self.phases = dict(state["since"]), dict(state["phases"])
        self._planned, self._asked = dict(state["planned"]), dict(state["asked"])
        self.changes = list(state["changes"])

    def _look(self, t: float, name: str, load: float) -> None:
        """Let a contact begin or cease to carry once its load has said so for long enough."""
        carries, settings = self._carries[name], self.settings
        other = load < settings.release if carries else load > settings.touch
        if not other:
            self._since[name] = None
            return
        since = self._since[name]
        if since is None:
            since = self._since[name] = t
        if t - since >= settings.dwell - 1e-9:
            self._carries[name], self._since[name] = not carries, None

    def _remember(self, t: float, name: str, planned: bool, load: float) -> None:
        """Keep in mind whether a contact has touched, and was loaded, since it was to carry."""
        settings = self.settings
        least = settings.touch if settings.loaded is None else settings.loaded
        if not (planned and self._carries[name] and load > least):
            self._heavy[name] = None
        elif self._heavy[name] is None:
            self._heavy[name] = t
        if not planned:
            self._touched[name], self._loaded[name] = self._carries[name], False
            return
        self._touched[name] = self._touched[name] or self._carries[name]
        since = self._heavy[name]
        if since is not None and t - since >= settings.steady - 1e-9:
            self._loaded[name] = True

    def _wait(self, t: float, name: str, planned: bool) -> None:
        """Begin to wait for what is newly planned, and cease when it is done or takes too long."""
        if planned is not self._planned[name]:
            self._planned[name], self._asked[name] = planned, t
        asked, patience = self._asked[name], self.settings.patience
        if asked is not None and (self._carries[name] is planned or t - asked >= patience - 1e-9):
            self._asked[name] = None

    def _phase(self, name: str, planned: bool) -> Phase:
        waits = self._asked[name] is not None
        if self._carries[name]:
            return Phase.HELD if planned or waits else Phase.TOUCHED
        if not planned or waits:
            return Phase.FREE
        if self._loaded[name]:
            return Phase.LOST
        return Phase.TOUCHED if self._touched[name] else Phase.LATE


def load_of(contact: Contact, lam: Array) -> float:
    """Return how hard a contact presses [N]: its normal force, or the size of its force."""
    if contact.normal_row is not None:
        return float(lam[contact.normal_row])
    force = [value for value, unit in zip(lam, contact.units, strict=True) if unit == "N"]
    return float(np.linalg.norm(force))
