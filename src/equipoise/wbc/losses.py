"""Supports that are lost without a plan, and found again: the others carry meanwhile."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from equipoise.contacts import ContactPhases, Phase, PhaseChange, PhaseSettings
from equipoise.control import Keep
from equipoise.spatial import Array
from equipoise.wbc.controller import WholeBodyController


class LossGuard:
    """Lets the contacts that are planned to support do so while they carry: `update` once a tick.

    A support that is LOST or LATE is left out until it touches; where the energy is to be kept, the
    others bear at once what it gave. The last one is never left out: nothing would carry the base.
    `phases` tells the story.
    """

    def __init__(
        self, controller: WholeBodyController, settings: PhaseSettings, keep: Keep = "energy"
    ) -> None:
        supports = [c for c in controller.supports.contacts.values() if c.supporting]
        held = [c.name for c in supports if c.name in controller.contacts.rows]
        self.controller, self.keep = controller, keep
        self.phases = ContactPhases(supports, held, settings)
        self._held = held

    @property
    def story(self) -> list[PhaseChange]:
        """Every change of a phase."""
        return self.phases.changes

    def update(self, t: float, planned: Collection[str], lam: Mapping[str, Array]) -> list[str]:
        """Switch if need be; return the names of the supports that hold in the tick of `t` [s].

        `planned` are the names of those that are to support, `lam` the multipliers of all of them,
        those that do not hold included.
        """
        phases = self.phases.update(t, planned, lam)
        carrying = [name for name in phases if phases[name] is Phase.HELD]
        if carrying and carrying != self._held:
            lost = any(phases[name] is Phase.LOST for name in self._held)
            self.controller.switch(carrying, self.keep if lost else "torque")
            self._held = carrying
        return list(self._held)

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory."""
        return {"phases": self.phases.state(), "held": list(self._held)}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state` returned."""
        self.phases.restore(state["phases"])
        self._held = list(state["held"])
