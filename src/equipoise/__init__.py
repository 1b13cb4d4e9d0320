"""Whole-body force-motion control of humanoids without a dynamic model of the robot.

What most programs need is here; families are in `equipoise.tasks`, `equipoise.trajectories`,
`equipoise.contacts` and `equipoise.contacts.surfaces`. Importing this package is cheap: what it
offers is imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.2.0"

_HOMES = {
    "ContactStack": "equipoise.contacts",
    "ControlGains": "equipoise.control",
    "ControlSettings": "equipoise.wbc",
    "EquipoiseError": "equipoise.errors",
    "Hierarchy": "equipoise.hqp",
    "InputError": "equipoise.errors",
    "InverseKinematics": "equipoise.motion",
    "Kinematics": "equipoise.kinematics",
    "LiveTarget": "equipoise.trajectories",
    "LoopSettings": "equipoise.wbc",
    "Measurement": "equipoise.control",
    "MotionGenerator": "equipoise.motion",
    "MujocoAdapter": "equipoise.adapters",
    "PassivityController": "equipoise.control",
    "Reference": "equipoise.control",
    "RigidContactEngine": "equipoise.physics",
    "Robot": "equipoise.robots",
    "Rows": "equipoise.hqp",
    "Run": "equipoise.runlog",
    "SoleContact": "equipoise.contacts",
    "Solution": "equipoise.hqp",
    "Waypoint": "equipoise.trajectories",
    "WaypointTrajectory": "equipoise.trajectories",
    "WholeBodyController": "equipoise.wbc",
    "advise_gains": "equipoise.control",
    "get_robot": "equipoise.robots",
    "load_robot": "equipoise.robots",
    "load_run": "equipoise.runlog",
    "make_solver": "equipoise.hqp",
    "read_scenario": "equipoise.scenarios",
    "run_scenario": "equipoise.api",
    "solve_posture": "equipoise.motion",
}

if TYPE_CHECKING:  # the same once more, for editors and type checkers; a test compares
    from equipoise.adapters import MujocoAdapter
    from equipoise.api import run_scenario
    from equipoise.contacts import ContactStack, SoleContact
    from equipoise.control import (
        ControlGains,
        Measurement,
        PassivityController,
        Reference,
        advise_gains,
    )
    from equipoise.errors import EquipoiseError, InputError
    from equipoise.hqp import Hierarchy, Rows, Solution, make_solver
    from equipoise.kinematics import Kinematics
    from equipoise.motion import InverseKinematics, MotionGenerator, solve_posture
    from equipoise.physics import RigidContactEngine
    from equipoise.robots import Robot, get_robot, load_robot
    from equipoise.runlog import Run, load_run
    from equipoise.scenarios import read_scenario
    from equipoise.trajectories import LiveTarget, Waypoint, WaypointTrajectory
    from equipoise.wbc import ControlSettings, LoopSettings, WholeBodyController
else:

    def __getattr__(name: str) -> object:
        if name not in _HOMES:
            raise AttributeError(f"module 'equipoise' has no attribute {name!r}")
        return getattr(import_module(_HOMES[name]), name)


__all__ = [
    "ContactStack",
    "ControlGains",
    "ControlSettings",
    "EquipoiseError",
    "Hierarchy",
    "InputError",
    "InverseKinematics",
    "Kinematics",
    "LiveTarget",
    "LoopSettings",
    "Measurement",
    "MotionGenerator",
    "MujocoAdapter",
    "PassivityController",
    "Reference",
    "RigidContactEngine",
    "Robot",
    "Rows",
    "Run",
    "SoleContact",
    "Solution",
    "Waypoint",
    "WaypointTrajectory",
    "WholeBodyController",
    "advise_gains",
    "get_robot",
    "load_robot",
    "load_run",
    "make_solver",
    "read_scenario",
    "run_scenario",
    "solve_posture",
]


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
