"""Whole-body force-motion control of humanoids without a dynamic model of the robot.

Importing this package is cheap: what it offers is imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "Robot": "equipoise.robots",
    "get_robot": "equipoise.robots",
    "load_robot": "equipoise.robots",
    "Run": "equipoise.runlog",
    "load_run": "equipoise.runlog",
    "read_scenario": "equipoise.scenarios",
    "run_scenario": "equipoise.api",
}

__all__ = ["Robot", "Run", "get_robot", "load_robot", "load_run", "read_scenario", "run_scenario"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'equipoise' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
