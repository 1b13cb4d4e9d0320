"""Our inverse-dynamics program against TSID's own, in a process of its own.

Skipped unless `EQUIPOISE_TSID_PYTHON` names a Python that has it (docs/rivals.md says how to get
one).
"""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

import pytest

PYTHON = os.environ.get("EQUIPOISE_TSID_PYTHON")
TOOL = Path(__file__).parents[3] / "benchmarks" / "compare_tsid.py"


@pytest.mark.skipif(PYTHON is None, reason="EQUIPOISE_TSID_PYTHON names no Python with tsid")
def test_both_programs_ask_for_the_same_torques():
    """With torques and soles at their bounds in a part of the states."""
    spec = importlib.util.spec_from_file_location("compare_tsid", TOOL)
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    found = tool.compare(PYTHON)
    assert found["no answer of TSID"] == 0
    assert found["states"] >= 30
    assert found["torque met"] >= 5
    assert found["floor met"] >= 5
    assert found["apart"] < 1e-6
