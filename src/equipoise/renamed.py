"""Names of version 0.1 that moved: they still work, and say where they are now."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Any

TRAJECTORIES = "equipoise.trajectories"
RENAMED = {
    "equipoise.tasks.AttachedTrajectory": f"{TRAJECTORIES}.AttachedTrajectory",
    "equipoise.tasks.Fade": f"{TRAJECTORIES}.Fade",
    "equipoise.tasks.FixedPose": f"{TRAJECTORIES}.FixedPose",
    "equipoise.tasks.PoseSample": f"{TRAJECTORIES}.PoseSample",
    "equipoise.tasks.PoseTrajectory": f"{TRAJECTORIES}.PoseTrajectory",
    "equipoise.tasks.TravelTrajectory": f"{TRAJECTORIES}.TravelTrajectory",
    "equipoise.tasks.Waypoint": f"{TRAJECTORIES}.Waypoint",
    "equipoise.tasks.WaypointTrajectory": f"{TRAJECTORIES}.WaypointTrajectory",
    "equipoise.distances.DistanceEvaluator": "equipoise.collision.distances.DistanceEvaluator",
    "equipoise.distances.PairDistance": "equipoise.collision.distances.PairDistance",
    "equipoise.world.Body": "equipoise.collision.scene.Body",
    "equipoise.world.Pair": "equipoise.collision.scene.Pair",
    "equipoise.world.Scene": "equipoise.collision.scene.Scene",
    "equipoise.world.Shape": "equipoise.collision.scene.Shape",
    "equipoise.control.Profile": f"{TRAJECTORIES}.Profile",
    "equipoise.control.Target": "equipoise.control.Reference",
}


def old_names_of(package: str) -> Callable[[str], Any]:
    """Return a package's `__getattr__`, which finds what it offered under another name before."""

    def find(name: str) -> Any:
        now = RENAMED.get(f"{package}.{name}")
        if now is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        warnings.warn(f"{package}.{name} is now {now}", DeprecationWarning, stacklevel=2)
        room, _, there = now.rpartition(".")
        return getattr(import_module(room), there)

    return find
