"""Points and lines of a study: even, repeatable, in range; bisection finds what is known."""

from __future__ import annotations

import made_up
import numpy as np
import pytest

from equipoise.studies.draw import axis_of, between, points_of, unit_points, value_at
from equipoise.studies.lines import lines_of
from equipoise.studies.plan import Plan, RunId, overrides_of, seed_of
from equipoise.studies.schema import BoundarySpec, ParameterSpec, SobolSpec

LOG = ParameterSpec(path="a", log_uniform=[0.5, 8.0], nominal=1.0)
LIST = ParameterSpec(path="a", choice=["a", "b", "c"])


def test_a_sobol_sequence_is_even_in_every_part_of_the_space() -> None:
    """Of 2^k points every box of volume 2^-k that is cut dyadically holds exactly one."""
    x = unit_points("sobol", 2, 64, seed=4)
    for i in range(7):
        boxes = np.floor(x * [2**i, 2 ** (6 - i)]).astype(int)
        assert len({tuple(box) for box in boxes}) == 64


def test_a_latin_hypercube_has_one_point_in_each_part_of_each_axis() -> None:
    x = unit_points("latin_hypercube", 5, 30, seed=1)
    for column in x.T:
        assert sorted(np.floor(30 * column).astype(int)) == list(range(30))


def test_the_first_points_stay_when_more_are_drawn() -> None:
    few, many = (unit_points("sobol", 3, count, seed=9) for count in (20, 200))
    assert np.array_equal(few, many[:20])
    assert not np.array_equal(few, unit_points("sobol", 3, 20, seed=10))


@pytest.mark.parametrize("u", [0.0, 0.3, 0.999999])
def test_values_are_within_their_range(u: float) -> None:
    assert 0.5 <= value_at(LOG, u) <= 8.0
    assert value_at(LOG, u) == pytest.approx(0.5 * 16.0**u)
    assert value_at(LIST, u) == ["a", "b", "c"][int(3 * u)]


def test_the_middle_of_a_logarithmic_range_is_a_geometric_mean() -> None:
    assert between(LOG, 0.5, 8.0, 0.5) == pytest.approx(2.0)
    assert [between(LOG, 0.5, 8.0, share) for share in (0.0, 1.0)] == [0.5, 8.0]
    assert axis_of(LOG, 5) == pytest.approx([0.5, 1.0, 2.0, 4.0, 8.0])
    assert axis_of(LIST, 99) == ["a", "b", "c"]


def test_a_grid_has_every_combination_and_the_rest_is_nominal() -> None:
    spec = made_up.study(designs={"map": {"kind": "grid", "over": {"load": 3}}})
    points = points_of(spec.parameters, spec.designs["map"])  # type: ignore[arg-type]
    assert points == [{"load": x, "delay": 0.0} for x in (0.0, 5.0, 10.0)]


def test_lines_go_from_nominal_to_every_end_that_is_not_there() -> None:
    parameters = {"mass": LOG, "name": LIST}
    design = BoundarySpec(kind="boundary", along="each")
    up, down = lines_of(parameters, design)
    assert (up.name, up.begin, up.end) == ("mass+", {"mass": 1.0}, {"mass": 8.0})
    assert (down.name, down.end) == ("mass-", {"mass": 0.5})


def test_bisection_closes_in_on_a_known_boundary() -> None:
    """Along the load at each delay: good below 9 - delay; the bracket halves with every step."""
    steps = 6
    design = {"kind": "boundary", "along": "load", "over": {"delay": 5}, "steps": steps}
    spec = made_up.study(designs={"edge": design})
    limit = {"first": 9.0, "second": 5.0}

    def formula(run):  # type: ignore[no-untyped-def]
        bad = run.values["load"] >= limit[run.controller] - run.values["delay"]
        return made_up.result(run, 0.05 if bad else 0.001)

    results = made_up.play(spec, formula)
    for contender, controller in enumerate(("first", "second")):
        for point, delay in enumerate((0.0, 2.0, 4.0, 6.0, 8.0)):
            ids = {key: RunId.read(key) for key in results}
            mine = [k for k, i in ids.items() if (i.point, i.contender) == (point, contender)]
            rows = [results[key]["row"] for key in mine]
            good = [row["values"]["load"] for row in rows if row["good"]]
            bad = [row["values"]["load"] for row in rows if not row["good"]]
            where = limit[controller] - delay
            if where <= 0.0:  # not even good at nominal: one run says so
                assert (len(good), len(bad)) == (0, 1)
                continue
            assert max(good) < where <= min(bad)
            assert min(bad) - max(good) == pytest.approx(10.0 / 2**steps)
            assert len(rows) == 2 + steps


def test_what_is_spared_is_not_expected() -> None:
    spec = made_up.study(designs={"edge": {"kind": "boundary", "along": "each", "steps": 3}})
    plan = Plan(spec)
    runs = list(plan.first())
    assert plan.most == 2 * 2 * 5
    plan.after(runs[0].id, good=False)
    assert plan.most == 20 - 4
    following = plan.after(runs[1].id, good=True)
    assert following is not None
    assert following.share == 1.0
    assert plan.after(following.id, good=True) is None
    assert plan.most == 20 - 4 - 3


def test_pairs_have_the_same_noise_and_no_two_points_have() -> None:
    spec = made_up.study(seeds=3)
    seeds: dict[tuple[int, int], set[int]] = {}
    for run in Plan(spec).first():
        seeds.setdefault((run.id.point, run.id.repeat), set()).add(seed_of(spec, run.id))
    assert all(len(of_a_pair) == 1 for of_a_pair in seeds.values())
    assert len(set.union(*seeds.values())) == 16 * 3


def test_what_a_run_sets_comes_in_order() -> None:
    """The study, then its controller, then the parameters: each may overwrite what came before."""
    spec = made_up.study(
        set={"x": -1.0, "duration": 1.0},
        controllers={"first": {"set": {"control.gains.alpha": 3.0}}, "second": {}},
        parameters={
            "load": {"paths": [{"path": "x"}, {"path": "y", "times": 0.5}], "uniform": [1.0, 2.0]}
        },
    )
    run = next(iter(Plan(spec).first()))
    load = run.values["load"]
    told = [("x", -1.0), ("duration", 1.0), ("control.gains.alpha", 3.0), ("x", load)]
    assert overrides_of(spec, run) == [*told, ("y", 0.5 * load), ("seed", seed_of(spec, run.id))]


def test_ids_are_read_back_in_the_order_of_results() -> None:
    ids = [RunId("a", 2, 0, 0), RunId("a", 10, 0, 0), RunId("a", 10, 1, 0, 3), RunId("b", 0, 0, 0)]
    assert [RunId.read(str(one)) for one in ids] == ids == sorted(reversed(ids))


def test_a_count_that_is_no_power_of_two_is_cut() -> None:
    design = SobolSpec(kind="sobol", points=5, seed=0)
    assert len(points_of({"mass": LOG}, design)) == 5
