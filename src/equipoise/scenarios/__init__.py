"""Scenarios: typed YAML files, read, changed, made for another robot; those that are shipped."""

from equipoise.scenarios.catalogue import named_scenarios, read_scenario
from equipoise.scenarios.overrides import apply_overrides
from equipoise.scenarios.read import parse_scenario, resolved_text
from equipoise.scenarios.schema import Scenario

__all__ = [
    "Scenario",
    "apply_overrides",
    "named_scenarios",
    "parse_scenario",
    "read_scenario",
    "resolved_text",
]
