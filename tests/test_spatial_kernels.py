"""Poses in kernels against Pinocchio's own algebra, also where rotations are small or half turns.

What kernels are compiled to has no way in from Python, hence `py_func`.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.compiled import entrance
from equipoise.spatial import pose_row
from equipoise.spatial.kernels import (
    compose,
    rotation_difference,
    rotation_matrix,
    rotation_rate,
    rotation_vector,
)


@entrance
def difference_alone(T_ref, T, out):
    out[0], out[1], out[2] = rotation_difference(T_ref, T)


ANGLES = (0.0, 1e-12, 1e-7, 1e-4, 0.3, 2.0, 3.1, np.pi - 1e-6, np.pi - 1e-9)


def turned_by(angle: float, rng: np.random.Generator) -> np.ndarray:
    axis = rng.normal(size=3)
    return angle * axis / np.linalg.norm(axis)


@pytest.mark.parametrize("angle", ANGLES)
def test_rotation_vectors_and_matrices_belong_together(angle, rng):
    x = turned_by(angle, rng)
    R = np.empty((3, 3))
    rotation_matrix.py_func(*x, R)
    assert np.allclose(R, pin.exp3(x), atol=1e-15)
    assert np.allclose(pin.exp3(np.array(rotation_vector.py_func(R))), R, atol=1e-14)
    if angle < 3.14:
        assert np.allclose(rotation_vector.py_func(R), x, atol=1e-13)


def test_a_half_turn_about_any_axis_is_found(rng):
    for axis in (*np.eye(3), *rng.normal(size=(20, 3))):
        n = axis / np.linalg.norm(axis)
        R = 2.0 * np.outer(n, n) - np.eye(3)
        found = np.array(rotation_vector.py_func(R))
        assert np.isclose(np.linalg.norm(found), np.pi)
        assert np.allclose(np.abs(found @ n), np.pi)


@pytest.mark.parametrize("angle", ANGLES)
def test_the_rate_of_a_rotation_vector_is_an_angular_velocity(angle, rng):
    x, rate = turned_by(angle, rng), rng.normal(size=3)
    wanted = pin.exp3(x) @ (pin.Jexp3(x) @ rate)
    assert np.allclose(rotation_rate.py_func(*x, *rate), wanted, atol=1e-12)


def test_poses_compose_and_differ_as_in_pinocchio(rng):
    for _ in range(20):
        A, B = pin.SE3.Random(), pin.SE3.Random()
        product = np.empty(12)
        compose.py_func(pose_row(A), pose_row(B), product)
        assert np.allclose(product, pose_row(A * B), atol=1e-14)
        wanted = pin.log3(A.rotation @ B.rotation.T)
        row_a, row_b = pose_row(A), pose_row(B)
        error = np.empty(3)
        difference_alone(row_a, row_b, error)
        assert np.allclose(error, wanted, atol=1e-9)
