"""Cameras: from world points to a picture plane and back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from equipoise.spatial import Array


@dataclass(frozen=True)
class Camera:
    """A camera at `eye` that looks at `target` [m, world], with a window in the picture plane.

    The picture plane goes through the target; `window` is (x_min, x_max, y_min, y_max) [m] in it,
    x to the right and y up. With `perspective` False all rays are parallel.
    """

    eye: Array
    target: Array
    window: tuple[float, float, float, float] = (-1.0, 1.0, -1.0, 1.0)
    perspective: bool = True

    @classmethod
    def around(
        cls,
        target: Array,
        azimuth: float,
        elevation: float,
        distance: float,
        *,
        perspective: bool = True,
    ) -> Camera:
        """Return a camera at `distance` [m] from the target, seen from these angles [rad].

        Azimuth 0 stands on the world's +x side and turns towards +y.
        """
        level = np.cos(elevation)
        towards = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
        target = np.asarray(target, dtype=float)
        return cls(target + distance * towards, target, perspective=perspective)

    @property
    def distance(self) -> float:
        """Distance [m] from eye to target."""
        return float(np.linalg.norm(self.target - self.eye))

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """Unit vectors (3,) to the right, up, and forward, in the world."""
        forward = (self.target - self.eye) / self.distance
        upright = np.array([0.0, 0.0, 1.0])
        if abs(forward[2]) > 1.0 - 1e-9:
            upright = np.array([0.0, 1.0, 0.0])
        right = np.cross(forward, upright)
        right /= np.linalg.norm(right)
        return right, np.cross(right, forward), forward

    def project(self, points: Array) -> Array:
        """Return (n, 3) of world points (n, 3): x, y [m] in the picture plane, and nearness.

        Nearness grows towards the eye, and varies linearly over the picture of a flat face. A
        point behind the eye has nearness NaN.
        """
        right, up, forward = self.axes
        relative = np.asarray(points) - self.eye
        x, y, depth = relative @ right, relative @ up, relative @ forward
        if not self.perspective:
            return np.column_stack([x, y, -depth / self.distance])
        visible = depth > 1e-3 * self.distance
        scale = np.divide(self.distance, depth, out=np.full_like(depth, np.nan), where=visible)
        return np.column_stack([x * scale, y * scale, scale])

    def unproject(self, picture: Array) -> Array:
        """Return the world points (n, 3) whose projections (n, 3) these are."""
        right, up, forward = self.axes
        x, y, nearness = picture[:, :1], picture[:, 1:2], picture[:, 2:]
        if not self.perspective:
            return self.eye + x * right + y * up - self.distance * nearness * forward
        return self.eye + (x * right + y * up + self.distance * forward) / nearness

    def rays(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return origins and directions (n, 3) of the rays through points [m] of the plane."""
        right, up, forward = self.axes
        across = x[:, None] * right + y[:, None] * up
        if self.perspective:
            return np.broadcast_to(self.eye, across.shape), across + self.distance * forward
        return self.eye + across, np.broadcast_to(forward, across.shape)

    def fitted(self, points: Array, margin: float = 0.03) -> Camera:
        """Return the camera whose window holds all points, with a margin [share of its size]."""
        picture = self.project(points)
        picture = picture[np.isfinite(picture).all(axis=1), :2]
        low, high = picture.min(axis=0), picture.max(axis=0)
        border = margin * float(max(high - low))
        x_min, y_min = (float(side) for side in low - border)
        x_max, y_max = (float(side) for side in high + border)
        return replace(self, window=(x_min, x_max, y_min, y_max))

    @property
    def aspect(self) -> float:
        """Width of the window over its height."""
        x_min, x_max, y_min, y_max = self.window
        return (x_max - x_min) / (y_max - y_min)
