"""What is logged of bodies that move by themselves: where they are and how far they lean."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.runlog import Channel
from equipoise.spatial import Array

LABELS = ("x", "y", "z", "qx", "qy", "qz", "qw", "tilt", "speed")
UNITS = ("m", "m", "m", "", "", "", "", "rad", "m/s")


class ObjectLog:
    """Logs the loose objects of an engine that has some; nothing for any other engine."""

    def __init__(self, engine: Any) -> None:
        self._engine = engine
        around = getattr(engine, "surroundings", None)
        self._names = tuple(thing.name for thing in around.loose) if around is not None else ()
        self._upright = {
            name: engine.object_pose(name).rotation.T[:, 2].copy() for name in self._names
        }

    @property
    def channels(self) -> list[Channel]:
        """One channel an object."""
        doc = "pose of a free body, quaternion xyzw; tilt from how it stood at the start"
        return [Channel(f"object/{name}", LABELS, UNITS, doc) for name in self._names]

    def values(self) -> dict[str, Array]:
        """Return the logged values of the present state."""
        values = {}
        for name in self._names:
            T = self._engine.object_pose(name)
            up = T.rotation @ self._upright[name]
            tilt = np.arctan2(np.linalg.norm(up[:2]), up[2])
            speed = np.linalg.norm(self._engine.object_twist(name)[:3])
            values[f"object/{name}"] = np.concatenate((pin.SE3ToXYZQUAT(T), [tilt, speed]))
        return values
