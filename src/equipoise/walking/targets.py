"""What a walk wants at a moment, in the form that tasks follow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from equipoise.spatial import Array, pose_row
from equipoise.trajectories import PoseSample, PoseTrajectory
from equipoise.trajectories.base import ROW

Numbers = Sequence[float] | Array
UPRIGHT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class LedPose(PoseTrajectory):
    """A pose that is led by whoever writes it: every tick follows what was written last."""

    def __init__(self, T_world_target: pin.SE3) -> None:
        self._row = np.zeros(ROW)
        self.write(T_world_target, np.zeros(6))

    def write(self, T_world_target: pin.SE3, twist: Array) -> None:
        """Let the pose be here and move with a twist (6,) in world axes."""
        self._row[:12] = pose_row(T_world_target)
        self._row[12:] = twist

    def write_point(self, point: Numbers, velocity: Numbers) -> None:
        """Let the origin be at a point (3,) [m] and move with a velocity (3,) [m/s]."""
        row = self._row  # numbers one by one: a slice takes five times as long
        row[9], row[10], row[11] = point
        row[12], row[13], row[14] = velocity

    def write_heading(self, columns: Sequence[Numbers], heading: float, spin: float) -> None:
        """Let the axes be these `columns` (3, 3), turned by `heading` [rad] about the vertical.

        They turn at `spin` [rad/s].
        """
        row, c, s = self._row, math.cos(heading), math.sin(heading)
        for k, (x, y, z) in enumerate(columns):
            row[3 * k], row[3 * k + 1], row[3 * k + 2] = c * x - s * y, s * x + c * y, z
        row[17] = spin

    def write_displaced(
        self, start: Array, place: Array, speed: Array, turned: tuple[float, float]
    ) -> None:
        """Let the pose be how somebody is displaced who was at `start` (3,) [m], and is at `place`.

        He moves at `speed` (3,) [m/s], and has `turned` by an angle [rad], at a rate [rad/s].
        """
        (turn, spin), (x, y, z) = turned, start
        c, sn = math.cos(turn), math.sin(turn)
        from_start = np.array([c * x - sn * y, sn * x + c * y, z])
        sweep = spin * np.array([-from_start[1], from_start[0], 0.0])
        self.write_heading(UPRIGHT, turn, spin)
        self.write_point(place - from_start, speed - sweep)

    def row(self, t: float) -> Array:
        """Return pose row and twist (18,)."""
        return self._row

    def at(self, t: float) -> PoseSample:
        """Return the pose and its rate."""
        T = pin.SE3(self._row[:9].reshape(3, 3).T.copy(), self._row[9:12].copy())
        return PoseSample(T, self._row[12:].copy())


@dataclass(frozen=True)
class WalkTargets:
    """The poses that a walk leads: both soles, the centre of mass, and frames that stay upright.

    `upright` maps a frame to the pose that is led, whose axes turn with the heading. `carrier` is
    how what is carried has been displaced since the start: with the planned centre of mass, the
    height of the ground and the heading.
    """

    soles: tuple[LedPose, LedPose]
    centre: LedPose
    upright: dict[str, LedPose] = field(default_factory=dict)
    carrier: LedPose | None = None

    @property
    def named(self) -> dict[str, LedPose]:
        """All of them by name."""
        left, right = self.soles
        found = {"left_foot": left, "right_foot": right, "centre": self.centre, **self.upright}
        return found if self.carrier is None else {**found, "carrier": self.carrier}
