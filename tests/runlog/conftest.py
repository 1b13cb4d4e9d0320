"""Small logs that every test of the log can make."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from equipoise.runlog import Channel, RunWriter

CHANNELS = (
    Channel("q", ("x", "y", "z"), ("m", "m", "rad"), "configuration"),
    Channel("lam/left_sole", ("f_x", "f_y"), "N", "contact force"),
    Channel("nothing", (), "", "a channel without components"),
    Channel("s", ("s",), ""),
)


def make_tick(generator: np.random.Generator) -> dict[str, np.ndarray]:
    """Draw one tick of values for CHANNELS."""
    return {channel.name: generator.normal(size=channel.size) for channel in CHANNELS}


def write_log(folder: Path, count: int, *, seed: int = 0, dt: float = 1e-3) -> list[dict]:
    """Write `count` random ticks and return them."""
    generator = np.random.default_rng(seed)
    ticks = [make_tick(generator) for _ in range(count)]
    with RunWriter(folder, CHANNELS, scenario_text="robot: hrp2\n", seed=seed) as writer:
        for i, tick in enumerate(ticks):
            writer.write(i * dt, tick)
    return ticks


@pytest.fixture
def write() -> Callable[..., list[dict]]:
    """Give the function that writes a random log."""
    return write_log


@pytest.fixture
def channels() -> tuple[Channel, ...]:
    """Give the channels of the random log."""
    return CHANNELS
