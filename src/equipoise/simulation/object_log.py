"""What is logged of bodies that move by themselves: where they are and how far they lean."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from equipoise.physics import PhysicsEngine
from equipoise.runlog import Channel, TickRecord

LABELS = ("x", "y", "z", "qx", "qy", "qz", "qw", "tilt", "speed")
UNITS = ("m", "m", "m", "", "", "", "", "rad", "m/s")


class ObjectLog:
    """Logs the loose objects of an engine; nothing where there are none."""

    def __init__(self, engine: PhysicsEngine) -> None:
        self._engine = engine
        self._names = engine.object_names
        self._upright = {
            name: engine.object_pose(name).rotation.T[:, 2].copy() for name in self._names
        }

    @property
    def channels(self) -> list[Channel]:
        """One channel an object."""
        doc = "pose of a free body, quaternion xyzw; tilt from how it stood at the start"
        return [Channel(f"object/{name}", LABELS, UNITS, doc) for name in self._names]

    def write(self, record: TickRecord) -> None:
        """Fill the views of the present state."""
        for name, upright in self._upright.items():
            row, T = record.views[f"object/{name}"], self._engine.object_pose(name)
            x, y, z = T.rotation @ upright
            row[:7] = pin.SE3ToXYZQUAT(T)
            row[7] = math.atan2(math.hypot(x, y), z)
            row[8] = np.linalg.norm(self._engine.object_twist(name)[:3])
