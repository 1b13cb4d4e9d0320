"""A run with what its scenario says about it, as far as it can still be read."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from equipoise.analysis.joint_groups import JointGroup, joint_groups_of
from equipoise.contacts import ReactionMargins
from equipoise.errors import EquipoiseError, RunLogError
from equipoise.robots.base import FLOATING
from equipoise.runlog import Run
from equipoise.scenarios import schema
from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build.setup import Setup, build_setup
from equipoise.spatial import Array, Mask

LOADED = 0.2  # share of all load above which a sole of a robot that walks has to stand


@dataclass(frozen=True, eq=False)
class RunContext:
    """A run; `known` says whether its scenario and setup could be read (any more)."""

    run: Run
    _scenario: schema.Scenario | None
    _setup: Setup | None

    @classmethod
    def of(cls, run: Run, setup: Setup | None = None) -> RunContext:
        """Return the context of a run; `setup` is built from its scenario unless given."""
        try:
            scenario = parse_scenario(run.scenario_text)
            return cls(run, scenario, setup or build_setup(scenario))
        except EquipoiseError:
            return cls(run, None, None)

    @property
    def known(self) -> bool:
        """Whether the run's scenario can be read."""
        return self._scenario is not None and self._setup is not None

    @property
    def scenario(self) -> schema.Scenario:
        """The scenario. Raises: `RunLogError` where it is not `known`."""
        if self._scenario is None:
            raise RunLogError("The scenario in the run's log can no longer be read.")
        return self._scenario

    @property
    def setup(self) -> Setup:
        """Robot, scene and contacts. Raises: `RunLogError` where they are not `known`."""
        if self._setup is None:
            raise RunLogError("The scenario in the run's log can no longer be read.")
        return self._setup

    @cached_property
    def settled(self) -> Mask:
        """Which ticks (N,) bool come after `acceptance.after`."""
        return self.run.t >= self.scenario.acceptance.after

    def errors_of(self, kind: type[schema.TaskBase]) -> list[Array]:
        """Return the pose error (N, 6) of each task of a kind."""
        return [
            self.run[f"error/{name}"]
            for name, spec in self.scenario.tasks.items()
            if isinstance(spec, kind) and f"error/{name}" in self.run
        ]

    def pushes(self) -> list[tuple[str, schema.PushContactSpec, schema.SliderSpec]]:
        """Return each pushing contact with the object it pushes."""
        return [
            (name, spec, self.scenario.world.sliders[spec.slider])
            for name, spec in self.scenario.contacts.items()
            if isinstance(spec, schema.PushContactSpec)
        ]

    def margins(self, kind: str) -> dict[str, Array]:
        """Return by sole one component (N,) of its reaction margins."""
        column = ReactionMargins.LABELS.index(kind)
        names = [name for name in self.run.names if name.startswith("margin/")]
        found = {name.removeprefix("margin/"): self.run[name][:, column] for name in names}
        if self.scenario.walk is not None:
            found = {name: self._where_loaded(name, values) for name, values in found.items()}
        return {**found, **self._margins_of_feet(kind)}

    def _where_loaded(self, sole: str, margins: Array) -> Array:
        """Return margins (N,) that are infinite where a sole has no more than a fifth of the load.

        A foot that is being put down or lifted may tip and slip: the other one carries.
        """
        names = [name for name in self.run.names if name.startswith("margin/")]
        loads = {name: self.run[name.replace("margin/", "lam/")][:, 2] for name in names}
        total = np.sum([np.maximum(load, 0.0) for load in loads.values()], axis=0)
        return np.where(loads[f"margin/{sole}"] > LOADED * total, margins, np.inf)

    def _margins_of_feet(self, kind: str) -> dict[str, Array]:
        """Return the same of feet that are points, which have no pressure and no yaw."""
        found = {}
        specs = self.scenario.contacts.items() if kind in ("normal", "friction") else ()
        for name, spec in specs:
            if isinstance(spec, schema.FootContactSpec) and f"lam/{name}" in self.run:
                x, y, z = self.run[f"lam/{name}"].T
                found[name] = z if kind == "normal" else spec.friction * z - np.hypot(x, y)
        return found

    def has(self, *channels: str) -> bool:
        """Return whether there are ticks, and numbers of all these channels in them."""
        run = self.run
        return run.t.size > 0 and all(c in run and run[c].shape[1] > 0 for c in channels)

    @property
    def drawable(self) -> bool:
        """Whether the robot is known and at least one of its configurations."""
        if not self.known or not self.has("q"):
            return False
        q = self.run["q"]
        return q.shape[1] == self.setup.robot.nq and bool(np.isfinite(q).all(axis=1).any())

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the actuated joints, from the log."""
        if "tau" in self.run.channels:
            return self.run.channels["tau"].labels
        if "q" not in self.run.channels:
            return ()
        labels = self.run.channels["q"].labels
        floats = labels[: len(FLOATING.position_names)] == FLOATING.position_names
        return labels[FLOATING.nq :] if floats else labels

    @property
    def joint_groups(self) -> list[JointGroup]:
        """How the joints are grouped."""
        return joint_groups_of(self.setup.robot if self.known else None, self.joint_names)

    @property
    def followed_frames(self) -> list[str]:
        """Tasks whose pose error is of interest: hands on objects, all logged ones without such."""
        logged = [name.removeprefix("error/") for name in self.run if name.startswith("error/")]
        specs = self.scenario.tasks if self.known else {}
        hands = [name for name in logged if isinstance(specs.get(name), schema.HandOnObjectSpec)]
        return hands or logged

    @property
    def security(self) -> dict[str, float]:
        """The distance [m] that each avoided pair has to keep."""
        tasks = self.scenario.tasks.values() if self.known else ()
        return {
            f"{first} - {second}": task.security
            for task in tasks
            if isinstance(task, schema.AvoidanceSpec) and task.enabled
            for first, second in task.pairs
        }

    @property
    def com_margin(self) -> float | None:
        """The distance [m] to the polygon's edge that a task keeps, None without such a task."""
        tasks = self.scenario.tasks.values() if self.known else ()
        margins = [t.margin for t in tasks if isinstance(t, schema.ComPolygonSpec) and t.enabled]
        return max(margins, default=None)
