"""Possible reactions against a linear programme over the four corners of the sole."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from equipoise.contacts import reaction_margins
from equipoise.robots import Sole

SOLE = Sole("sole", "frame", -0.1, 0.13, -0.056, 0.075)
FRICTION = 0.7


def corners_can(lam: np.ndarray) -> bool:
    """Whether forces at the corners, each in a square friction pyramid, add up to `lam`."""
    rays, columns = [], []
    for corner in SOLE.corners:
        for fx in (-FRICTION, FRICTION):
            for fy in (-FRICTION, FRICTION):
                ray = np.array([fx, fy, 1.0])
                rays.append(ray)
                columns.append(np.concatenate((ray, np.cross(corner, ray))))
    result = linprog(np.zeros(16), A_eq=np.array(columns).T, b_eq=lam, bounds=(0, None))
    return result.status == 0


def test_margins_agree_with_corner_forces(rng):
    """The closed form is exact for the pyramid, so both say the same on random wrenches."""
    verdicts = []
    for _ in range(300):
        fz = rng.uniform(50, 400)
        lam = np.array(
            [
                *rng.uniform(-0.6, 0.6, 2) * FRICTION * fz,
                fz,
                rng.uniform(-0.09, 0.09) * fz,
                rng.uniform(-0.15, 0.15) * fz,
                rng.uniform(-0.12, 0.12) * fz,
            ]
        )
        margins = reaction_margins(lam, SOLE, FRICTION)
        pyramid = FRICTION * fz - np.abs(lam[:2]).max()
        ours = min(margins.normal, pyramid, margins.pressure, margins.yaw) >= 0.0
        verdicts.append(ours)
        assert ours == corners_can(lam), lam
    assert 50 < sum(verdicts) < 250


def test_pressure_margin_is_a_distance():
    """A force at a known point: the margin is its distance to the nearest edge."""
    point = np.array([0.11, 0.03, 0.0])
    force = np.array([0.0, 0.0, 200.0])
    margins = reaction_margins(np.concatenate((force, np.cross(point, force))), SOLE, FRICTION)
    assert margins.pressure == pytest.approx(0.02)
    assert margins.friction == pytest.approx(140.0)
    assert margins.possible


def test_pulling_is_impossible():
    margins = reaction_margins(np.array([0, 0, -1.0, 0, 0, 0]), SOLE, FRICTION)
    assert not margins.possible
    assert margins.pressure == -np.inf
