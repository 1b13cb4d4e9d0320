"""The generators of mutated files, in small: no tracebacks, and both outcomes happen."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module", autouse=True)
def tools():
    sys.path.insert(0, str(ROOT / "benchmarks"))
    yield
    sys.path.remove(str(ROOT / "benchmarks"))


def tool(name: str) -> ModuleType:
    return importlib.import_module(name)


@pytest.mark.parametrize("block", range(3))
def test_mutated_descriptions_are_refused_or_sound(block, tmp_path):
    cases = range(50 * block, 50 * block + 50)
    outcomes = tool("fuzzing").run_here(tool("fuzz_urdf").outcome, cases, tmp_path)
    assert outcomes.bad == {}
    assert outcomes.counts["refused"] > 10
    assert outcomes.counts["loaded"] > 3


@pytest.mark.slow
def test_mutated_scenarios_are_refused_or_run(tmp_path):
    cases = range(5000, 5040)
    outcomes = tool("fuzzing").run_here(tool("fuzz_scenarios").outcome, cases, tmp_path)
    assert outcomes.bad == {}
    assert outcomes.counts["refused"] > 10
    assert outcomes.counts["ran"] > 3


def test_the_same_seed_gives_the_same_case(tmp_path):
    for seed in (1, 2, 3):
        texts = []
        for _ in range(2):
            path = tool("fuzz_urdf").write_case(seed, tmp_path / "one")
            texts.append([p.read_bytes() for p in sorted(path.parent.glob("robot.*"))])
        assert texts[0] == texts[1]
        assert tool("fuzz_scenarios").case_of(seed) == tool("fuzz_scenarios").case_of(seed)


def misbehaving(seed: int, folder: Path) -> str:
    """Return, raise, hang or die, as the seed says."""
    import os
    import time

    if seed == 1:
        raise RuntimeError("what should not come out")
    if seed == 2:
        time.sleep(60.0)
    if seed == 3:
        os._exit(7)
    return "fine"


def test_what_hangs_or_dies_is_counted_and_the_rest_is_run(monkeypatch):
    fuzzing = tool("fuzzing")
    outcomes = fuzzing.run_apart(misbehaving, [0, 1, 2, 3, 4, 5], 1.0)
    assert outcomes.counts == {"fine": 3, "traceback": 1, "hang": 1, "crash": 1}
    assert set(outcomes.bad) == {1, 2, 3}
    assert "what should not come out" in outcomes.bad[1]
    assert "exit code 7" in outcomes.bad[3]
