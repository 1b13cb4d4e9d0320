"""Fixtures that many tests share."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.robots import Robot, get_robot


@pytest.fixture(scope="session")
def hrp2() -> Robot:
    """The shipped robot."""
    return get_robot("hrp2")


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator with a fixed seed."""
    return np.random.default_rng(20261122)
