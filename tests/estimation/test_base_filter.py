"""The filter of the base: its equations against its own steps, and what it finds."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pinocchio as pin
import pytest

from equipoise import SoleContact, get_robot
from equipoise.errors import InputError
from equipoise.estimation import BaseFilter, FilterNoise
from equipoise.estimation.kernels import correct, predict

DT = 1e-3
ROBOT = get_robot("hrp2")
START = ROBOT.at(ROBOT.q_half_sitting)
SOLES = [SoleContact(s.frame, sole=s, T_world_anchor=START.placement(s.frame)) for s in ROBOT.soles]
JOINTS = ROBOT.q_half_sitting[7:]


def at_rest(rate=(0.0, 0.0, 0.0), felt=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Return what an inertial unit shows of the standing robot, with biases."""
    R = pin.Quaternion(ROBOT.q_half_sitting[3:7]).toRotationMatrix()
    up = 9.81 * R[2]
    return np.concatenate((ROBOT.q_half_sitting[3:7], rate, up + np.array(felt)))


def moving() -> BaseFilter:
    """Return a filter in the midst of a motion: nothing of its state is zero."""
    one, random = BaseFilter(ROBOT, SOLES), np.random.default_rng(0)
    one.step(0.0, JOINTS, at_rest())
    one.move(0.3 * random.normal(size=len(one.variance)))
    return one


def error_of(guess: BaseFilter, true: BaseFilter) -> np.ndarray:
    """Return the right-invariant error (n,) of a state, to first order."""
    turn = guess.R @ true.R.T
    parts = [pin.log3(turn), guess.v - turn @ true.v, guess.p - turn @ true.p]
    parts += [a - turn @ b for a, b in zip(guess.feet, true.feet, strict=True)]
    parts += [guess.rate_bias - true.rate_bias, guess.acceleration_bias - true.acceleration_bias]
    return np.concatenate(parts)


@pytest.mark.parametrize("seed", range(4))
def test_the_error_moves_as_the_transition_says(seed):
    """Two states that differ by a little are moved on by the same measurements."""
    random = np.random.default_rng(seed)
    true = moving()
    guess = deepcopy(true)
    xi = 1e-6 * random.normal(size=len(true.variance))
    guess.move(xi)
    np.testing.assert_allclose(error_of(guess, true), xi, atol=1e-10)
    rate, felt = random.normal(size=3), 5.0 * random.normal(size=3)
    wanted = true.transition(DT) @ xi
    for one in (true, guess):
        predict(one._x, one.variance, np.concatenate((rate, felt)), DT, one._numbers)
    moved = error_of(guess, true) - xi
    np.testing.assert_allclose(moved, wanted - xi, atol=2e-2 * np.abs(wanted - xi).max())


@pytest.mark.parametrize("seed", range(4))
def test_what_the_legs_show_is_linear_in_the_error(seed):
    """Away from a state that fits the joints, z is H times the error."""
    one = BaseFilter(ROBOT, SOLES)
    one.step(0.0, JOINTS, at_rest())
    before, H = one.seen(JOINTS)
    xi = 1e-5 * np.random.default_rng(seed).normal(size=len(one.variance))
    one.move(xi)
    np.testing.assert_allclose(one.seen(JOINTS)[0] - before, H @ xi, atol=1e-9)


def skew_of(x: np.ndarray) -> np.ndarray:
    return np.cross(np.eye(3), x)


def test_the_variance_moves_as_the_filter_of_kalman_has_it():
    """Against the matrices as they are printed: adjoint, gain for all at once, Joseph's form."""
    one, noise, random = moving(), FilterNoise(), np.random.default_rng(3)
    n = len(one.variance)
    root = random.normal(size=(n, n))
    one.variance[:] = 1e-4 * (root @ root.T + np.eye(n))
    P, R, step = one.variance.copy(), one.R.copy(), one.transition(DT)
    adjoint = np.eye(n)
    adjoint[:3, :3] = R
    places = (one.v, one.p, *one.feet)
    for k, place in enumerate(places, start=1):
        at = slice(3 * k, 3 * k + 3)
        adjoint[at, at], adjoint[at, :3] = R, skew_of(place) @ R
    walks = [noise.rate_bias, noise.acceleration_bias]
    white = [noise.rate, noise.acceleration, 0.0, noise.slip, noise.slip, *walks]
    Q = adjoint @ np.diag(np.repeat(white, 3) ** 2) @ adjoint.T
    predict(one._x, one.variance, np.concatenate((0.1 * np.ones(3), np.ones(3))), DT, one._numbers)
    P = step @ (P + DT * Q) @ step.T
    np.testing.assert_allclose(one.variance, P, rtol=1e-9, atol=1e-12)
    z, H = one.seen(JOINTS)
    N = np.diag(np.tile(np.repeat([noise.place, noise.angle], 3) ** 2, 2))
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + N)
    other = deepcopy(one)
    correct(one._x, one.variance, one._placements(JOINTS), one._anchor_rows, one._numbers)
    other.move(-K @ z)
    keep = np.eye(n) - K @ H
    np.testing.assert_allclose(one._x, other._x, atol=1e-8)
    np.testing.assert_allclose(one.variance, keep @ P @ keep.T + K @ N @ K.T, atol=1e-9)


def test_a_robot_at_rest_stays_where_it_is():
    one = BaseFilter(ROBOT, SOLES)
    for _ in range(500):
        pose, twist = one.step(DT, JOINTS, at_rest())
    np.testing.assert_allclose(pose, ROBOT.q_half_sitting[:7], atol=1e-9)
    np.testing.assert_allclose(twist, 0.0, atol=1e-9)


def test_biases_are_found_and_do_not_let_it_drift():
    rate, felt = np.array([0.02, -0.01, 0.03]), np.array([0.05, -0.1, 0.08])
    one = BaseFilter(ROBOT, SOLES, FilterNoise(rate_bias=1e-2, acceleration_bias=1e-1))
    for _ in range(4000):
        pose, twist = one.step(DT, JOINTS, at_rest(rate, felt))
    np.testing.assert_allclose(one.rate_bias, rate, atol=2e-3)
    assert np.linalg.norm(pose[:3] - ROBOT.q_half_sitting[:3]) < 1e-3
    assert np.linalg.norm(twist[:3]) < 5e-3


def test_noise_is_averaged_and_the_spread_is_honest():
    """Errors of place, of many runs, lie within three of the standard deviations it tells."""
    noise, random = FilterNoise(), np.random.default_rng(1)
    one, errors = BaseFilter(ROBOT, SOLES, noise), []
    white = np.repeat([noise.rate, noise.acceleration], 3) / np.sqrt(DT)
    for k in range(3000):
        imu = at_rest()
        imu[4:] += white * random.normal(size=6)
        pose, _ = one.step(DT, JOINTS, imu)
        if k >= 500:
            errors.append(pose[:3] - ROBOT.q_half_sitting[:3])
    rms = np.sqrt((np.array(errors) ** 2).sum(axis=1).mean())
    assert rms < 3.0 * one.spread[0]
    assert rms < 2e-3


def test_the_variance_stays_symmetric_and_positive():
    one = BaseFilter(ROBOT, SOLES)
    for _ in range(200):
        one.step(DT, JOINTS, at_rest())
    np.testing.assert_allclose(one.variance, one.variance.T, atol=1e-15)
    assert np.linalg.eigvalsh(one.variance).min() > 0.0


def test_what_cannot_be_estimated_is_refused():
    with pytest.raises(InputError, match="stands on soles"):
        BaseFilter(ROBOT, [])
    with pytest.raises(InputError, match="slip must be"):
        FilterNoise(slip=0.0)
