"""Poses from outside, checked once where they enter: finite, near, and a rotation indeed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError, NonFiniteError
from equipoise.spatial.numbers import real_array
from equipoise.spatial.se3 import Array, pose_row

FARTHEST = 1e6  # [m] a place further away than this is a slip; its squares still have all digits
ROUNDING = 1e-5  # of R^T R against the identity: what single precision leaves


def pose(xyz: Sequence[float] | Array, rpy: Sequence[float] | Array = (0.0, 0.0, 0.0)) -> pin.SE3:
    """Return the placement with translation `xyz` [m] and roll-pitch-yaw angles `rpy` [rad].

    The rotation is R_z(yaw) R_y(pitch) R_x(roll), as in URDF.
    Raises: `InputError`, `ShapeError`, `NonFiniteError`.
    """
    place = near("xyz", real_array("xyz", xyz, (3,)))
    return pin.SE3(pin.rpy.rpyToMatrix(*real_array("rpy", rpy, (3,))), place)


def rigid(what: str, T: object) -> pin.SE3:
    """Return a pose that is one: finite, near, its matrix a right-handed rotation.

    `what` says in errors whose pose it is.
    Raises: `InputError`; `NonFiniteError` for a NaN or an infinity.
    """
    if not isinstance(T, pin.SE3):
        raise InputError(
            f"{what} must be a pinocchio.SE3",
            given=type(T).__name__,
            remedy="Make one with `equipoise.spatial.pose(xyz, rpy)` or `pinocchio.SE3(R, p)`",
        )
    if _row_if_rigid(T) is not None:
        return T
    R = np.array(T.rotation)
    if not (np.isfinite(R).all() and np.isfinite(T.translation).all()):
        raise NonFiniteError(f"{what} is not finite", given=T.homogeneous.tolist())
    near(what, np.array(T.translation))
    rotation(what, R)
    return T


def rigid_row(what: str, T: object) -> list[float]:
    """Return a checked pose as kernels read it (12 numbers): see `pose_row` and `rigid`."""
    row = _row_if_rigid(T) if isinstance(T, pin.SE3) else None
    return row if row is not None else pose_row(rigid(what, T)).tolist()


def _row_if_rigid(T: pin.SE3) -> list[float] | None:
    """Return the row of a pose that is fine: plain arithmetic, as targets come a thousand a second.

    A NaN is no smaller than anything.
    """
    (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = T.homogeneous.tolist()
    if (
        abs(a * a + d * d + g * g - 1.0) <= ROUNDING
        and abs(b * b + e * e + h * h - 1.0) <= ROUNDING
        and abs(c * c + f * f + i * i - 1.0) <= ROUNDING
        and abs(a * b + d * e + g * h) <= ROUNDING
        and abs(a * c + d * f + g * i) <= ROUNDING
        and abs(b * c + e * f + h * i) <= ROUNDING
        and a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0.0
        and abs(x) <= FARTHEST
        and abs(y) <= FARTHEST
        and abs(z) <= FARTHEST
    ):
        return [a, d, g, b, e, h, c, f, i, x, y, z]
    return None


def rotation(what: str, R: Array) -> Array:
    """Return a matrix (3, 3) that is a rotation. Raises: `InputError`."""
    off = float(np.abs(R.T @ R - np.eye(3)).max())
    if not off <= ROUNDING:
        raise InputError(
            f"the matrix of {what} is no rotation: R^T R is {off:.2g} off the identity",
            given=R.tolist(),
            remedy="Build it from angles or a unit quaternion, or take the nearest rotation: "
            "with U, _, Vt = np.linalg.svd(R), that is U @ Vt",
        )
    if np.linalg.det(R) < 0.0:
        raise InputError(
            f"the matrix of {what} is left-handed (determinant -1): a mirror, no rotation",
            given=R.tolist(),
            remedy="Turn one of its axes round, for instance the third column, if the axes were "
            "meant to be right-handed",
        )
    return R


def near(what: str, place: Array) -> Array:
    """Return a place (3,) [m] that is not absurdly far away. Raises: `InputError`."""
    if np.abs(place).max() > FARTHEST:
        raise InputError(
            f"{what} lies more than {FARTHEST:g} m away",
            given=place.tolist(),
            remedy="Lengths are in metres",
        )
    return place


def unit_vector(what: str, values: object) -> Array:
    """Return a unit vector (3,). Raises: `InputError`, `ShapeError`, `NonFiniteError`."""
    given = real_array(what, values, (3,))
    length = float(np.linalg.norm(given))
    if not abs(length - 1.0) <= ROUNDING:
        raise InputError(
            f"{what} must be a unit vector (3,)",
            given=given.tolist(),
            remedy="Divide it by its length" if length > 0.0 else "Name a direction",
        )
    return given
