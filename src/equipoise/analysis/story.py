"""A run with what its scenario says about it, as far as it can still be read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.analysis.limbs import Limb, limbs_of
from equipoise.errors import EquipoiseError
from equipoise.runlog import Run
from equipoise.scenarios.places import Places
from equipoise.scenarios.schema import AvoidanceSpec, ComPolygonSpec, HandOnObjectSpec, Scenario

_BASE_NUMBERS = 7


@dataclass(frozen=True, eq=False)
class Story:
    """A run; its scenario and places are None where its text cannot be read (any more)."""

    run: Run
    scenario: Scenario | None
    places: Places | None

    @classmethod
    def of(cls, run: Run) -> Story:
        """Return the story of a run."""
        from equipoise.scenarios.places import build_places
        from equipoise.scenarios.read import parse_scenario

        try:
            scenario = parse_scenario(run.scenario_text)
            return cls(run, scenario, build_places(scenario))
        except EquipoiseError:
            return cls(run, None, None)

    def has(self, *channels: str) -> bool:
        """Return whether there are ticks, and numbers of all these channels in them."""
        run = self.run
        return run.t.size > 0 and all(c in run and run[c].shape[1] > 0 for c in channels)

    @property
    def drawable(self) -> bool:
        """Whether the robot is known and at least one of its configurations."""
        if self.places is None or not self.has("q"):
            return False
        q = self.run["q"]
        return q.shape[1] == self.places.robot.nq and bool(np.isfinite(q).all(axis=1).any())

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the actuated joints, from the log."""
        if "tau" in self.run.channels:
            return self.run.channels["tau"].labels
        return self.run.channels["q"].labels[_BASE_NUMBERS:] if "q" in self.run.channels else ()

    @property
    def limbs(self) -> list[Limb]:
        """How the joints are grouped."""
        return limbs_of(self.places.robot if self.places else None, self.joint_names)

    @property
    def followed_frames(self) -> list[str]:
        """Tasks whose pose error is of interest: hands on objects, all logged ones without such."""
        logged = [name.removeprefix("error/") for name in self.run if name.startswith("error/")]
        specs = self.scenario.tasks if self.scenario else {}
        hands = [name for name in logged if isinstance(specs.get(name), HandOnObjectSpec)]
        return hands or logged

    @property
    def security(self) -> dict[str, float]:
        """The distance [m] that each avoided pair has to keep."""
        tasks = self.scenario.tasks.values() if self.scenario else ()
        return {
            f"{first} - {second}": task.security
            for task in tasks
            if isinstance(task, AvoidanceSpec) and task.enabled
            for first, second in task.pairs
        }

    @property
    def com_margin(self) -> float | None:
        """The distance [m] to the polygon's edge that a task keeps, None without such a task."""
        tasks = self.scenario.tasks.values() if self.scenario else ()
        margins = [t.margin for t in tasks if isinstance(t, ComPolygonSpec) and t.enabled]
        return max(margins, default=None)
