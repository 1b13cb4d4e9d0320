"""Coordinates of the base: rates of rotation parameters to twists (2)-(3), and wrenches (17).

The rest of Equipoise works with tangent velocities and needs none of this; it is for states and
forces that are written in rotation parameters theta (l,), l >= 3.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.spatial import Array, skew


class RotationCoordinates(ABC):
    """Parameters theta (l,) of a rotation R(theta) that maps body axes to world axes."""

    name: str
    labels: tuple[str, ...]

    @abstractmethod
    def rotation(self, theta: Array) -> Array:
        """Return R (3, 3)."""

    @abstractmethod
    def parameters(self, R: Array) -> Array:
        """Return theta (l,) of a rotation R (3, 3)."""

    @abstractmethod
    def derivative(self, theta: Array) -> Array:
        """Return `dR/dtheta` (l, 3, 3): one matrix a parameter."""

    @property
    def size(self) -> int:
        """Number l of parameters."""
        return len(self.labels)

    def rate_map(self, theta: Array) -> Array:
        """Return `J_theta` (3, l): world angular velocity from the rate of theta.

        Source: eq. (3). Differs from the print: none; r_i are the columns of R.
        """
        if theta.shape != (self.size,):
            raise ShapeError(f"theta of {self.name}", theta.shape, (self.size,))
        R, slopes = self.rotation(theta), self.derivative(theta)
        J_theta = np.zeros((3, self.size))
        for i in range(3):
            J_theta += 0.5 * skew(R[:, i]) @ slopes[:, :, i].T
        return J_theta


class RollPitchYaw(RotationCoordinates):
    """Angles [rad] of `R = R_z(yaw) R_y(pitch) R_x(roll)`; singular at pitch = +-pi/2."""

    name = "roll-pitch-yaw"
    labels = ("roll", "pitch", "yaw")

    def rotation(self, theta: Array) -> Array:
        """Return R (3, 3)."""
        return pin.rpy.rpyToMatrix(theta)

    def parameters(self, R: Array) -> Array:
        """Return theta (3,) [rad]."""
        return pin.rpy.matrixToRpy(R)

    def derivative(self, theta: Array) -> Array:
        """Return `dR/dtheta` (3, 3, 3)."""
        axes = np.eye(3)
        about_x, about_y, about_z = (
            pin.exp3(angle * axis) for angle, axis in zip(theta, axes, strict=True)
        )
        return np.stack(
            (
                about_z @ about_y @ about_x @ skew(axes[0]),
                about_z @ about_y @ skew(axes[1]) @ about_x,
                skew(axes[2]) @ about_z @ about_y @ about_x,
            )
        )


class UnitQuaternion(RotationCoordinates):
    """Quaternion xyzw of unit length, `R = (w^2 - |p|^2) I + 2 p p^T + 2 w [p x]`."""

    name = "unit quaternion"
    labels = ("x", "y", "z", "w")

    def rotation(self, theta: Array) -> Array:
        """Return R (3, 3)."""
        p, w = theta[:3], theta[3]
        return (w * w - p @ p) * np.eye(3) + 2.0 * np.outer(p, p) + 2.0 * w * skew(p)

    def parameters(self, R: Array) -> Array:
        """Return theta (4,)."""
        return pin.Quaternion(R).coeffs()

    def derivative(self, theta: Array) -> Array:
        """Return `dR/dtheta` (4, 3, 3), the four taken as independent."""
        p, w = theta[:3], theta[3]
        slopes = [
            2.0 * (-p[i] * np.eye(3) + np.outer(e, p) + np.outer(p, e) + w * skew(e))
            for i, e in enumerate(np.eye(3))
        ]
        return np.stack([*slopes, 2.0 * (w * np.eye(3) + skew(p))])


class RotationVector(RotationCoordinates):
    """Axis times angle [rad], `R = exp([theta x])`; singular at full turns."""

    name = "rotation vector"
    labels = ("x", "y", "z")

    def rotation(self, theta: Array) -> Array:
        """Return R (3, 3)."""
        return pin.exp3(theta)

    def parameters(self, R: Array) -> Array:
        """Return theta (3,) [rad]."""
        return pin.log3(R)

    def derivative(self, theta: Array) -> Array:
        """Return `dR/dtheta` (3, 3, 3), from Rodrigues' formula term by term."""
        K = skew(theta)
        f, g, f_slope, g_slope = _rodrigues(float(np.sqrt(theta @ theta)))
        slopes = []
        for i, e in enumerate(np.eye(3)):
            E = skew(e)
            of_factors = theta[i] * (f_slope * K + g_slope * K @ K)
            slopes.append(of_factors + f * E + g * (E @ K + K @ E))
        return np.stack(slopes)


class MatrixEntries(RotationCoordinates):
    """The nine entries of R, column by column."""

    name = "matrix entries"
    labels = tuple(f"r{row}{column}" for column in (1, 2, 3) for row in (1, 2, 3))

    def rotation(self, theta: Array) -> Array:
        """Return R (3, 3)."""
        return theta.reshape(3, 3).T

    def parameters(self, R: Array) -> Array:
        """Return theta (9,)."""
        return R.T.reshape(9)

    def derivative(self, theta: Array) -> Array:
        """Return `dR/dtheta` (9, 3, 3): one entry each."""
        return np.eye(9).reshape(9, 3, 3).transpose(0, 2, 1)


ROTATION_COORDINATES: dict[str, RotationCoordinates] = {
    kind.name: kind
    for kind in (RollPitchYaw(), UnitQuaternion(), RotationVector(), MatrixEntries())
}


def rotation_coordinates(name: str) -> RotationCoordinates:
    """Return rotation coordinates by name.

    Raises: `NameNotFoundError`.
    """
    if name not in ROTATION_COORDINATES:
        raise NameNotFoundError("rotation coordinates named", name, ROTATION_COORDINATES)
    return ROTATION_COORDINATES[name]


def base_rate_map(coordinates: RotationCoordinates, theta: Array) -> Array:
    """Return `J_x` (6, 3 + l): twist (velocity of the origin, world angular velocity) from rates.

    Source: eq. (2). Differs from the print: none.
    """
    J_x = np.zeros((6, 3 + coordinates.size))
    J_x[:3, :3] = np.eye(3)
    J_x[3:, 3:] = coordinates.rate_map(theta)
    return J_x


def contact_wrench(
    coordinates: RotationCoordinates, theta: Array, gradient: Array, lam: Array
) -> Array:
    """Return the wrench (6,) in world axes that does the work of `lam` (r,) in the coordinates.

    `gradient` (r, 3 + l) holds the rows `d phi / d(position, theta)`; for l > 3 only its part
    along motions that keep theta a rotation does work.
    Source: eq. (17). Differs from the print: for l > 3 `J_x` is not square, so `J_x^-T` is read
    as the pseudo-inverse of `J_x^T`; where l = 3 the two are the same.
    Raises: `ShapeError`; `InputError` at a singularity of the coordinates.
    """
    J_x = base_rate_map(coordinates, theta)
    if gradient.shape != (lam.shape[0], J_x.shape[1]):
        raise ShapeError("gradient", gradient.shape, (lam.shape[0], J_x.shape[1]))
    spread = np.linalg.svd(J_x[3:, 3:], compute_uv=False)
    if spread[-1] < 1e-9 * spread[0]:
        raise InputError(
            f"{coordinates.name} coordinates are singular here",
            given=[float(value) for value in theta],
            remedy="Use another parametrisation, such as the unit quaternion",
        )
    return np.linalg.pinv(J_x.T) @ gradient.T @ lam


def wrench_gradient(coordinates: RotationCoordinates, theta: Array, rows: Array) -> Array:
    """Return `d phi / d(position, theta)` (r, 3 + l) of rows (r, 6) that act on the twist."""
    return rows @ base_rate_map(coordinates, theta)


def _rodrigues(angle: float) -> tuple[float, float, float, float]:
    """Return `sin a / a`, `(1 - cos a) / a^2` and their slopes divided by a."""
    if angle < 1e-2:  # series: the next terms are below 1e-15
        s = angle * angle
        return (
            1.0 - s / 6.0 + s * s / 120.0 - s**3 / 5040.0,
            0.5 - s / 24.0 + s * s / 720.0 - s**3 / 40320.0,
            -1.0 / 3.0 + s / 30.0 - s * s / 840.0 + s**3 / 45360.0,
            -1.0 / 12.0 + s / 180.0 - s * s / 6720.0 + s**3 / 453600.0,
        )
    sine, cosine = float(np.sin(angle)), float(np.cos(angle))
    f, g = sine / angle, (1.0 - cosine) / angle**2
    return f, g, (cosine - f) / angle**2, (f - 2.0 * g) / angle**2
