"""A whole scenario file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from equipoise.scenarios.schema.acceptance import AcceptanceSpec
from equipoise.scenarios.schema.base import Name, Section, Title
from equipoise.scenarios.schema.contacts import ContactSpec
from equipoise.scenarios.schema.control import ControlSpec
from equipoise.scenarios.schema.disturbances import DisturbancesSpec, FaultsSpec, SensorsSpec
from equipoise.scenarios.schema.physics import PhysicsSpec
from equipoise.scenarios.schema.tasks import (
    AvoidanceSpec,
    DampingSpec,
    FloorSupportSpec,
    MomentumSpec,
    TaskSpec,
)
from equipoise.scenarios.schema.walk import WalkSpec
from equipoise.scenarios.schema.world import WorldSpec


class Scenario(Section):
    """A whole scenario."""

    name: Name
    title: Title = ""
    robot: str = "hrp2"
    duration: Annotated[float, Field(gt=0.0, le=3600.0)]
    seed: Annotated[int, Field(ge=0)] = 0
    world: WorldSpec = WorldSpec()
    contacts: dict[Name, ContactSpec] = {}
    tasks: Annotated[dict[Name, TaskSpec], Field(min_length=1)]
    walk: WalkSpec | None = None
    monitor: list[Annotated[list[str], Field(min_length=2, max_length=2)]] = []
    control: ControlSpec = ControlSpec()
    physics: PhysicsSpec = PhysicsSpec()
    disturbances: DisturbancesSpec = DisturbancesSpec()
    sensors: SensorsSpec = SensorsSpec()
    faults: FaultsSpec = FaultsSpec()
    acceptance: AcceptanceSpec = AcceptanceSpec()

    @model_validator(mode="after")
    def _slow_enough(self) -> Scenario:
        """Refuse rates with which a tick would go past what it approaches."""
        period = self.control.period
        for path, rate in self._rates():
            if rate * period > 1.0 + 1e-9:
                raise PydanticCustomError(
                    "too_fast",
                    f"{rate:g} 1/s is too fast for control.period {period:g} s: every tick would "
                    f"go past what it approaches; at most {1.0 / period:.6g} 1/s",
                    {"at": path},
                )
        return self

    def _rates(self) -> Iterator[tuple[tuple[str, ...], float]]:
        """Yield the path of every rate [1/s], and the rate."""
        yield ("control", "contact_rate"), self.control.contact_rate
        for gain in ("alpha", "beta_p", "beta_F", "eta"):
            yield ("control", "gains", gain), getattr(self.control.gains, gain)
        if self.walk is not None:
            yield ("walk", "foot_rate"), self.walk.foot_rate
            yield ("walk", "rate"), self.walk.rate
        for name, task in self.tasks.items():
            if isinstance(task, AvoidanceSpec):
                yield ("tasks", name, "damping"), task.damping / (task.influence - task.security)
            elif not isinstance(task, FloorSupportSpec | DampingSpec | MomentumSpec):
                yield ("tasks", name, "rate"), task.rate
