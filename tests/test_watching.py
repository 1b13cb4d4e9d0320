"""Compiling is told while it happens, once, and never where kernels are only loaded."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(
    os.environ.get("NUMBA_DISABLE_JIT", "0") != "0", reason="nothing is compiled"
)

KERNELS = """
import numpy as np
from equipoise.contacts.support_polygon import least_room
from equipoise.contacts.wrench_cone import margins_of
from equipoise.trajectories.minimum_jerk import step  # one that other kernels take in

def call():
    least_room(np.eye(2), np.ones(2), 0.1, 0.2)
    margins_of(np.ones(6), np.ones(5))
    step(0.5)
"""
WATCHED = f"""
from equipoise.compiled import watch_compilation
{KERNELS}
told = []
with watch_compilation(told.append):
    call()
    call()
print(told)
"""
STRANGER = """
import numba
from equipoise.compiled import watch_compilation
told = []
with watch_compilation(told.append):
    numba.njit(lambda x: x + 1.0)(2.0)
print(told)
"""


def run(code: str, cache: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
    )


def test_a_watcher_is_told_of_every_kernel_the_first_time_only(tmp_path):
    told = [True, False] * 3
    assert run(WATCHED, tmp_path).stdout.strip() == str(told)
    assert run(WATCHED, tmp_path).stdout.strip() == "[]"


def test_without_a_watcher_one_line_warns_the_first_time_only(tmp_path):
    first, second = (run(f"{KERNELS}\ncall()", tmp_path).stderr for _ in range(2))
    assert first.count("Compiling kernels") == 1
    assert "one to two minutes" in first
    assert second == ""


def test_what_others_compile_is_not_ours_to_tell(tmp_path):
    assert run(STRANGER, tmp_path).stdout.strip() == "[]"
