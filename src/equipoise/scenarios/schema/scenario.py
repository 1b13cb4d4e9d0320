"""A whole scenario file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from equipoise.scenarios.schema.acceptance import AcceptanceSpec
from equipoise.scenarios.schema.base import Name, Section, Title
from equipoise.scenarios.schema.contacts import ContactSpec
from equipoise.scenarios.schema.control import ControlSpec
from equipoise.scenarios.schema.disturbances import DisturbancesSpec, FaultsSpec, SensorsSpec
from equipoise.scenarios.schema.physics import PhysicsSpec
from equipoise.scenarios.schema.tasks import TaskSpec
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
    monitor: list[Annotated[list[str], Field(min_length=2, max_length=2)]] = []
    control: ControlSpec = ControlSpec()
    physics: PhysicsSpec = PhysicsSpec()
    disturbances: DisturbancesSpec = DisturbancesSpec()
    sensors: SensorsSpec = SensorsSpec()
    faults: FaultsSpec = FaultsSpec()
    acceptance: AcceptanceSpec = AcceptanceSpec()
