"""Surfaces: derivatives against finite differences, distances against geometry, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from contacts_surface_kinds import KINDS
from equipoise.contacts.surfaces import (
    Cylinder,
    Ellipsoid,
    ImplicitSurface,
    Plane,
    Sphere,
    Torus,
    VanishingGradientError,
    WrongDerivativeError,
)
from equipoise.errors import InputError, NonFiniteError, ShapeError

STEP = 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_are_those_of_phi(kind, rng):
    surface = KINDS[kind]
    for x in rng.uniform(0.05, 0.4, (20, 3)):
        slopes = [
            (surface.value(x + STEP * e) - surface.value(x - STEP * e)) / (2 * STEP)
            for e in np.eye(3)
        ]
        bends = [
            (surface.gradient(x + STEP * e) - surface.gradient(x - STEP * e)) / (2 * STEP)
            for e in np.eye(3)
        ]
        scale = max(1.0, np.abs(surface.hessian(x)).max())
        assert np.allclose(surface.gradient(x), slopes, atol=1e-8 * scale)
        assert np.allclose(surface.hessian(x), bends, atol=1e-7 * scale)


@pytest.mark.parametrize("kind", KINDS)
def test_normal_points_to_growing_phi_and_projection_lands_on_the_surface(kind, rng):
    surface = KINDS[kind]
    for x in rng.uniform(0.05, 0.4, (20, 3)):
        foot = surface.project(x)
        assert abs(surface.distance(foot)) < 1e-9
        n = surface.normal(foot)
        assert np.isclose(np.linalg.norm(n), 1.0)
        assert surface.value(foot + 1e-4 * n) > 0.0 > surface.value(foot - 1e-4 * n)


@pytest.mark.parametrize("kind", ["plane", "sphere", "cylinder", "torus"])
def test_phi_of_the_round_ones_is_the_distance(kind, rng):
    """No point of the surface, found by a general minimiser, is nearer than |phi|."""
    surface = KINDS[kind]
    for x in rng.uniform(0.1, 0.4, (3, 3)):
        foot = minimize(
            lambda y, x=x: np.sum((y - x) ** 2),
            surface.project(x + 0.01),
            constraints={"type": "eq", "fun": surface.value},
            tol=1e-14,
        ).x
        assert np.isclose(abs(surface.value(x)), np.linalg.norm(foot - x), atol=1e-6)


def test_distance_of_the_others_is_right_to_first_order(rng):
    """One hundredth of the step makes the error ten thousand times smaller."""
    surface = Ellipsoid((0.1, 0.2, 0.35))
    foot = surface.project(rng.uniform(0.05, 0.3, 3))
    errors = [
        abs(surface.distance(foot + height * surface.normal(foot)) - height)
        for height in (1e-2, 1e-4)
    ]
    assert errors[1] < 3e-4 * errors[0]


@pytest.mark.parametrize(
    ("surface", "place"),
    [
        (Sphere(0.2), (0.0, 0.0, 0.0)),
        (Cylinder(0.2), (0.0, 0.0, 1.0)),
        (Ellipsoid((0.1, 0.2, 0.3)), (0.0, 0.0, 0.0)),
        (Torus(0.3, 0.1), (0.3, 0.0, 0.0)),
        (Torus(0.3, 0.1), (0.0, 0.0, 0.4)),
    ],
)
def test_where_there_is_no_normal_the_surface_is_named(surface, place):
    with pytest.raises(VanishingGradientError, match=surface.name):
        surface.normal(np.array(place))


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan, np.inf])
def test_impossible_sizes_are_refused(length):
    for build in (Sphere, Cylinder, lambda r: Torus(0.3, r), lambda r: Ellipsoid((0.1, r, 0.1))):
        with pytest.raises(InputError, match="finite and positive"):
            build(length)
    with pytest.raises(InputError, match="thinner"):
        Torus(0.1, 0.2)
    with pytest.raises(ShapeError, match="semi_axes"):
        Ellipsoid((0.1, 0.2))


def ball(**changes) -> ImplicitSurface:
    """Return a ball of radius 0.2 as a user would write it, with one function replaced."""
    functions = {
        "phi": lambda x: x @ x - 0.04,
        "phi_gradient": lambda x: 2 * x,
        "phi_hessian": lambda x: 2 * np.eye(3),
        **changes,
    }
    return ImplicitSurface("ball", near=(0.0, 0.0, 0.25), **functions)


def test_a_users_surface_is_that_of_the_same_shape(rng):
    ours, theirs = Sphere(0.2), ball()
    for direction in rng.normal(size=(10, 3)):
        x = 0.2 * direction / np.linalg.norm(direction)
        assert np.allclose(ours.normal(x), theirs.normal(x))
        projector = np.eye(3) - np.outer(ours.normal(x), ours.normal(x))
        curvature = projector @ theirs.hessian(x) @ projector / theirs.steepness(x)
        assert np.allclose(curvature, ours.hessian(x))


def test_a_wrong_derivative_is_refused_by_name():
    with pytest.raises(WrongDerivativeError, match=r"gradient of surface 'ball'"):
        ball(phi_gradient=lambda x: 2.001 * x)
    with pytest.raises(WrongDerivativeError, match=r"gradient of surface 'ball'"):
        ball(phi_gradient=lambda x: -2 * x)
    with pytest.raises(WrongDerivativeError, match=r"Hessian of surface 'ball'"):
        ball(phi_hessian=lambda x: np.eye(3))
    with pytest.raises(WrongDerivativeError, match=r"Hessian of surface 'ball'"):
        ball(phi_hessian=lambda x: 2 * np.diag([1.0, 1.0, 0.999]))


def test_a_double_zero_is_refused_because_its_gradient_vanishes():
    with pytest.raises((VanishingGradientError, InputError), match="ball"):
        ball(
            phi=lambda x: (x @ x - 0.04) ** 2,
            phi_gradient=lambda x: 4 * (x @ x - 0.04) * x,
            phi_hessian=lambda x: 8 * np.outer(x, x) + 4 * (x @ x - 0.04) * np.eye(3),
        )


def test_a_surface_without_a_zero_is_refused():
    with pytest.raises(InputError, match=r"no point of surface 'ball' is reached|vanishes"):
        ball(phi=lambda x: x @ x + 0.04)


def test_shapes_and_numbers_of_a_users_functions_are_checked():
    with pytest.raises(ShapeError, match="gradient of surface 'ball'"):
        ball(phi_gradient=lambda x: 2 * x[:2])
    with pytest.raises(ShapeError, match="Hessian of surface 'ball'"):
        ball(phi_hessian=lambda x: 2 * np.eye(2))
    with pytest.raises(NonFiniteError, match="ball"):
        ball(phi_hessian=lambda x: np.full((3, 3), np.nan))
    with pytest.raises(InputError, match="radius"):
        ImplicitSurface("p", lambda x: x[2], lambda x: x, lambda x: x, (0, 0, 0), radius=-1.0)


def test_a_plane_is_flat():
    assert np.array_equal(Plane().hessian(np.ones(3)), np.zeros((3, 3)))
