"""The MuJoCo engine spends its time in MuJoCo."""

from __future__ import annotations

import pytest

pytest.importorskip("mujoco")

from equipoise.bench.engine_share import engine_rows, step_share


def test_most_of_a_control_period_is_mujocos_own():
    rows = engine_rows("tray_real", ticks=200)
    assert [row.name for row in rows] == [
        "engine/mujoco/tray_real",
        "engine/mujoco/tray_real/mj_step",
    ]
    assert 0.5 < step_share(rows) < 1.3
