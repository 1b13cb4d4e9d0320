"""The ground of the rigid engine: a floor with blocks on it, told from above."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.errors import InputError
from equipoise.physics.rigid.ground import Block, Ground


def test_the_highest_block_under_a_point_counts(rng):
    """Against a search over points of the blocks' own axes."""
    turned = pin.SE3(pin.utils.rotate("z", 0.5), np.array([1.0, 0.0, 0.05]))
    low, high = Block(turned, (0.4, 0.2, 0.1)), Block(turned, (0.2, 0.1, 0.3))
    ground = Ground(-0.01, (low, high))
    for _ in range(200):
        own = rng.uniform(-0.3, 0.3, size=3)
        inside = [abs(own[0]) <= 0.5 * b.size[0] and abs(own[1]) <= 0.5 * b.size[1]
                  for b in (low, high)]  # fmt: skip
        expected = 0.2 if inside[1] else 0.1 if inside[0] else -0.01
        assert ground.under(turned.act(own)) == pytest.approx(expected)


def test_a_block_that_leans_is_refused():
    with pytest.raises(InputError, match="level tops"):
        Block(pin.SE3(pin.utils.rotate("x", 0.1), np.zeros(3)), (1.0, 1.0, 1.0))
