"""The telephone and the curved surfaces in closed loop."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise import run_scenario

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def telephone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("telephone") / "run"
    return run_scenario("telephone", out=folder, figures=False)


def missed(run):
    return {n: r for n, r in run.summary["metrics"].items() if not r.get("passed", True)}


def test_the_telephone_meets_its_acceptance(telephone):
    assert not missed(telephone)
    assert telephone.summary["passed"]


def test_it_is_approached_touched_pushed_and_released(telephone):
    t = telephone.t
    force, wanted = telephone["lam/push"][:, 0], telephone["lam_ref/push"][:, 0]
    travel = telephone["slider/telephone"][:, 0]
    assert np.all(force[t < 1.0] == 0.0)
    resting = (t > 1.8) & (t < 2.1)
    assert np.allclose(force[resting], 3.0, atol=0.1)
    assert np.ptp(travel[resting]) == 0.0
    assert wanted.max() > 10.0
    assert np.all(force[t > 5.7] == 0.0)
    assert travel[-1] == pytest.approx(0.15, abs=0.005)


@pytest.mark.parametrize("name", ["sphere", "cylinder"])
def test_a_palm_slides_along_a_curved_surface(name, tmp_path):
    run = run_scenario(name, out=tmp_path / "run", figures=False)
    assert not missed(run)
    after_contact = run.t > 0.05  # before, the force is on its way from nothing
    assert run["lam/press"][after_contact].min() > 0.0
