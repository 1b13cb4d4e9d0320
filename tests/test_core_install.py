"""The core controls without scipy and plotting; what needs them says which extra brings them."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import distributions
from pathlib import Path

HIDDEN = ("scipy", "matplotlib", "PIL", "kiwisolver", "contourpy", "fontTools", "viser", "mujoco")
CODE = """
import sys, warnings

class Hide:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {hidden!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Hide())
import numpy as np
from equipoise import run_scenario
from equipoise.analysis.figures.make import make_figures
from equipoise.errors import AdviceWarning, InputError
from equipoise.hqp.certificate import _non_negative

with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    run = run_scenario("sphere", out={out!r}, overrides=["duration=0.02"])
assert [w for w in told if w.category is AdviceWarning and "equipoise[plot]" in str(w.message)]
assert not list(run.folder.glob("figures/*"))
if {robots!r}:
    from equipoise.robots import get_robot
    print(get_robot("panda").mass)  # with collision meshes
refused = []
for ask in (
    lambda: make_figures(run, run.folder / "figures"),
    lambda: _non_negative(np.eye(2), np.ones(2)),
):
    try:
        ask()
    except InputError as error:
        refused.append(str(error))
assert len(refused) == 2, refused
assert "equipoise[plot]" in refused[0], refused
assert "equipoise[scipy]" in refused[1], refused
print(sorted(name for name in {hidden!r} if name in sys.modules))
"""


def test_the_core_runs_a_scenario_without_what_only_draws(tmp_path: Path) -> None:
    robots = "example-robot-data" in {one.name for one in distributions()}
    code = CODE.format(hidden=HIDDEN, out=str(tmp_path / "run"), robots=robots)
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.strip().endswith("[]")
