"""(2), (3), (17): rate maps against Pinocchio and finite differences; power is a scalar."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.spatial.coordinates import (
    ROTATION_COORDINATES,
    base_rate_map,
    contact_wrench,
    rotation_coordinates,
    wrench_gradient,
)

STEP = 1e-6


@pytest.fixture(params=list(ROTATION_COORDINATES))
def coordinates(request):
    return ROTATION_COORDINATES[request.param]


def rotations(rng, count=10):
    """Return random rotations, and some small ones where series take over."""
    large = [pin.exp3(rng.normal(size=3)) for _ in range(count)]
    small = [pin.exp3(rng.normal(size=3) * size) for size in (1e-2, 5e-3, 1e-4, 0.0)]
    return large + small


def test_parameters_and_rotation_are_inverses(coordinates, rng):
    for R in rotations(rng):
        assert np.allclose(coordinates.rotation(coordinates.parameters(R)), R, atol=1e-12)


def test_derivative_is_that_of_the_rotation(coordinates, rng):
    for R in rotations(rng):
        theta = coordinates.parameters(R)
        for i, e in enumerate(np.eye(coordinates.size)):
            ahead, behind = (coordinates.rotation(theta + sign * STEP * e) for sign in (1, -1))
            slope = (ahead - behind) / (2 * STEP)
            assert np.allclose(coordinates.derivative(theta)[i], slope, atol=1e-8)


def test_rates_give_the_angular_velocity(coordinates, rng):
    """Turn with a known world angular velocity, differentiate theta, map it back."""
    for R in rotations(rng):
        omega = rng.normal(size=3)
        ahead, behind = (
            coordinates.parameters(pin.exp3(sign * STEP * omega) @ R) for sign in (1, -1)
        )
        if coordinates.name == "unit quaternion" and ahead @ behind < 0.0:  # two for one rotation
            behind = -behind
        rate = (ahead - behind) / (2 * STEP)
        assert np.allclose(coordinates.rate_map(coordinates.parameters(R)) @ rate, omega, atol=1e-7)


def test_roll_pitch_yaw_map_is_pinocchios(rng):
    for _ in range(10):
        theta = rng.uniform(-1.2, 1.2, 3)
        expected = pin.rpy.computeRpyJacobian(theta, pin.ReferenceFrame.WORLD)
        assert np.allclose(rotation_coordinates("roll-pitch-yaw").rate_map(theta), expected)


def test_rotation_vector_map_is_the_left_jacobian(rng):
    for size in (1e-5, 1e-3, 0.3, 2.0):
        theta = rng.normal(size=3) * size
        expected = pin.Jexp3(-theta)  # right Jacobian of the inverse = left Jacobian
        assert np.allclose(rotation_coordinates("rotation vector").rate_map(theta), expected)


def test_rows_instead_of_columns_would_be_the_wrong_velocity(rng):
    """(3) with the rows of R for r_i gives minus the body's angular velocity, not the world's."""
    coordinates = rotation_coordinates("matrix entries")
    R, omega = pin.exp3(rng.normal(size=3)), rng.normal(size=3)
    theta = coordinates.parameters(R.T)  # columns of R^T are rows of R
    rate = coordinates.parameters((pin.skew(omega) @ R).T)
    assert np.allclose(coordinates.rate_map(theta) @ rate, -R.T @ omega)


def test_the_wrench_is_the_same_in_all_coordinates(rng):
    """One constraint on a pose, one lam: four gradients of different length, one wrench."""
    for R in rotations(rng):
        rows, lam = rng.normal(size=(2, 6)), rng.normal(size=2)
        for coordinates in ROTATION_COORDINATES.values():
            theta = coordinates.parameters(R)
            gradient = wrench_gradient(coordinates, theta, rows)
            wrench = contact_wrench(coordinates, theta, gradient, lam)
            assert np.allclose(wrench, rows.T @ lam, atol=1e-9)


def test_a_gradient_from_finite_differences_gives_the_force_of_geometry(coordinates, rng):
    """phi = n . (p + R r): its wrench is the force n lam at the lever R r, in any coordinates."""
    n, r, p = rng.normal(size=(3, 3))
    R = pin.exp3(rng.normal(size=3))
    theta, lam = coordinates.parameters(R), np.array([7.0])
    slopes = [
        n @ (coordinates.rotation(theta + STEP * e) - coordinates.rotation(theta - STEP * e)) @ r
        for e in np.eye(coordinates.size)
    ]
    gradient = np.concatenate((n, np.array(slopes) / (2 * STEP)))[None]
    force = 7.0 * n
    expected = np.concatenate((force, np.cross(R @ r, force)))
    assert np.allclose(contact_wrench(coordinates, theta, gradient, lam), expected, atol=1e-6)
    assert p.shape == (3,)


def test_power_is_the_same_in_all_coordinates(coordinates, rng):
    R, omega, velocity = pin.exp3(rng.normal(size=3)), rng.normal(size=3), rng.normal(size=3)
    theta = coordinates.parameters(R)
    ahead, behind = (coordinates.parameters(pin.exp3(s * STEP * omega) @ R) for s in (1, -1))
    rates = np.concatenate((velocity, (ahead - behind) / (2 * STEP)))
    rows, lam = rng.normal(size=(1, 6)), np.array([3.0])
    gradient = wrench_gradient(coordinates, theta, rows)
    wrench = contact_wrench(coordinates, theta, gradient, lam)
    power = np.concatenate((velocity, omega)) @ wrench
    assert np.isclose(lam @ gradient @ rates, power, atol=1e-6)
    assert base_rate_map(coordinates, theta).shape == (6, 3 + coordinates.size)


def test_bad_input_is_refused():
    with pytest.raises(NameNotFoundError, match="unit quaternion"):
        rotation_coordinates("unit quaternoin")
    euler = rotation_coordinates("roll-pitch-yaw")
    with pytest.raises(ShapeError, match="theta"):
        euler.rate_map(np.zeros(4))
    with pytest.raises(ShapeError, match="gradient"):
        contact_wrench(euler, np.zeros(3), np.zeros((1, 7)), np.zeros(1))
    level = np.array([0.1, np.pi / 2, 0.2])
    with pytest.raises(InputError, match="singular"):
        contact_wrench(euler, level, np.zeros((1, 6)), np.zeros(1))
