"""The engine's kernels run uncompiled give the same periods."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")

CODE = """
import sys
import numpy as np
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.engines import make_engine
from equipoise.simulation.build.setup import build_setup

found = []
for name in ("tray", "telephone"):
    scenario = read_scenario(name, ["physics.engine=mujoco"])
    setup = build_setup(scenario)
    engine = make_engine(scenario, setup, setup.robot.q_half_sitting)
    engine.external = np.linspace(-3.0, 3.0, setup.robot.nv)
    for _ in range(3):
        state = engine.step(np.linspace(-1.0, 1.0, setup.robot.na))
        found += [state.q, state.v, state.lam, [state.violation]]
np.save(sys.argv[1], np.concatenate(found))
"""


def test_both_ways_give_the_same_states(tmp_path: Path):
    found = []
    for disabled in ("0", "1"):
        path = tmp_path / f"{disabled}.npy"
        subprocess.run(
            [sys.executable, "-c", CODE, path],
            check=True,
            env={**os.environ, "NUMBA_DISABLE_JIT": disabled},
        )
        found.append(np.load(path))
    assert np.allclose(*found, rtol=1e-9, atol=1e-9)
    assert np.abs(found[0]).max() > 1.0
