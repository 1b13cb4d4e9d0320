"""Damaged logs and killed runs, a few of each; the tools in `benchmarks` do many."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.mark.parametrize("commands", [False, True])
def test_of_damaged_logs_nothing_is_lost_without_a_word(commands: bool, tmp_path: Path) -> None:
    tool = runpy.run_path(str(BENCHMARKS / "fuzz_logs.py"))
    outcomes = tool["fuzz"](5 if commands else 60, 7, tmp_path, commands=commands)
    assert not any(outcomes[name] for name in tool["FAILURES"]), outcomes
    assert commands or min(outcomes["told"], outcomes["refused"], outcomes["whole"]) > 0


def test_the_fuzzer_notices_what_it_looks_for(tmp_path: Path) -> None:
    """A reader that says nothing, or gives other numbers, is caught."""
    tool = runpy.run_path(str(BENCHMARKS / "fuzz_logs.py"))
    tool["fuzz"](1, 0, tmp_path)
    log = tool["load_run"](tmp_path / "whole")
    judge, path = tool["judge"], tmp_path / "whole"
    assert judge(path, log) == "whole"
    broken = log.__class__(**{**vars(log), "seed": log.seed + 1})
    assert judge(path, broken) == "wrong"
    longer = tool["load_run"](tmp_path / "whole", stride=1)
    object.__setattr__(longer, "t", longer.t + 1e-4)
    assert judge(path, longer) == "wrong"


@pytest.mark.slow
def test_killed_runs_leave_what_they_had(capfd: pytest.CaptureFixture[str]) -> None:
    tool = runpy.run_path(str(BENCHMARKS / "kill_runs.py"))
    assert tool["main"](["--count", "4", "--seed", "3"]) == 0
    assert "4 killed runs" in capfd.readouterr().out
