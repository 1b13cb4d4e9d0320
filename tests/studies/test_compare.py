"""Comparisons of made-up studies: what was put in comes out, in tables, figures and files."""

from __future__ import annotations

import re
from pathlib import Path

import made_up
import numpy as np
import pytest
from click.testing import CliRunner

from equipoise.cli import cli
from equipoise.errors import InputError, RunLogError
from equipoise.studies.compare import write
from equipoise.studies.compare.boundaries import brackets, survival
from equipoise.studies.compare.figures.make import figure_of, panels
from equipoise.studies.compare.pairs import sampled_rows
from equipoise.studies.compare.tables import against, all_tables, as_latex, causes, margins, success
from equipoise.studies.journal import Result
from equipoise.studies.plan import StudyRun
from equipoise.studies.results import Results, load_results

pytest.importorskip("pyarrow")

REACH = {"first": 0.8, "second": 0.6, "third_$%": 0.4}


def formula(run: StudyRun) -> Result:
    """Good while the sum of both shares of their ranges stays below the controller's reach."""
    used = run.values["load"] / 10.0 + run.values["delay"] / 8.0
    reach = REACH[run.controller]
    return made_up.result(run, 0.02 * used / reach, stands=used < 1.5 * reach)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    spec = made_up.study(
        title="Made up & <b>bold</b>",
        controllers={"first": {}, "second": {"title": "the second"}},
        designs={
            "main": {"kind": "sobol", "points": 32},
            "map": {"kind": "grid", "over": {"load": 4, "delay": 3}},
            "edge": {"kind": "boundary", "along": "load", "over": {"delay": 3}, "steps": 5},
            "margins": {"kind": "boundary", "along": "each", "steps": 5},
            "survival": {"kind": "boundary", "along": "all", "points": 8, "steps": 6},
        },
    )
    return made_up.write(spec, formula, tmp_path_factory.mktemp("made_up") / "study")


@pytest.fixture(scope="module")
def results(place: Path) -> Results:
    return load_results(place)


def used(results: Results, rows: np.ndarray) -> np.ndarray:
    return results["p.load"][rows] / 10.0 + results["p.delay"][rows] / 8.0


def test_the_tables_count_what_was_put_in(results: Results) -> None:
    rows = sampled_rows(results)
    good = {name: used(results, mine) < REACH[name] for name, mine in rows.items()}
    table = success(results)
    assert [row[2].split()[0] for row in table.rows] == [
        f"{int(mask.sum())}/32" for mask in good.values()
    ]
    (row,) = [row for row in against(results, "first").rows if row[1] == "good"]
    both, only_first, only_second, neither = map(int, row[2:6])
    assert (both, only_second) == (int(good["second"].sum()), 0)  # the second reaches less far
    assert only_first == int(good["first"].sum()) - both
    assert both + only_first + neither == 32
    counted = {row[0]: list(map(int, row[1:])) for row in causes(results).rows}
    for k, name in enumerate(("first", "second")):
        fallen = int((used(results, rows[name]) >= 1.5 * REACH[name]).sum())
        assert counted["fell"][k] == fallen
        assert counted["path_error"][k] == 32 - int(good[name].sum()) - fallen


def test_pairs_are_on_the_same_points(results: Results) -> None:
    first, second = sampled_rows(results).values()
    for name in ("p.load", "p.delay", "repeat", "point"):
        assert np.array_equal(results[name][first], results[name][second])


def test_brackets_hold_the_boundary(results: Results) -> None:
    for one in brackets(results, "edge"):
        delay = one.line.rest["delay"] / 8.0
        where = REACH[one.controller] - delay
        if where <= 0.0:
            assert np.isnan(one.low)
            assert one.middle == 0.0
        else:
            assert one.low < where <= one.high
            assert one.middle == pytest.approx(where, abs=1.0 / 2**6)
    for row in margins(results, "margins").rows:
        for cell, name in zip(row[1:], ("first", "second"), strict=True):
            low, high = map(float, cell.split(" to "))
            assert low < REACH[name] * {"load [kg]": 10.0, "delay [ms]": 8.0}[row[0]] <= high


def test_survival_is_the_share_of_lines_that_are_still_good(results: Results) -> None:
    found = [one for one in brackets(results, "survival") if one.controller == "second"]
    ends = np.array([one.line.end["load"] / 10.0 + one.line.end["delay"] / 8.0 for one in found])
    scales = np.linspace(0.0, 1.0, 21)
    low, high = survival(found, scales)
    true = (ends[None, :] * scales[:, None] < 0.6).mean(axis=1)
    assert (low <= true).all()
    assert (true <= high).all()
    assert (high - low).max() <= 0.5
    assert (np.diff(low) <= 0.0).all()


def test_every_figure_can_be_drawn_and_shows_its_controllers(results: Results) -> None:
    names = [panel.name for panel in panels(results, "first")]
    assert names == [
        *("success", "difference_path_error", "difference_torque_effort", "map_first"),
        *("map_second", "boundary_edge", "survival_survival", "effort", "causes", "ticks"),
    ]
    for panel in panels(results, "first"):
        figure = figure_of(panel)
        figure.canvas.draw()
        said = " ".join(
            text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text"))
        )
        assert "the second" in said or panel.name == "map_first", panel.name


def test_a_spider_has_a_spoke_for_every_direction(tmp_path: Path) -> None:
    parameters = {
        "load": {"path": "x", "uniform": [0.0, 10.0], "nominal": 0.0},
        "delay": {"path": "y", "uniform": [-8.0, 8.0], "nominal": 0.0},
    }
    designs = {"alone": {"kind": "boundary", "along": "each", "steps": 2}}
    spec = made_up.study(parameters=parameters, designs=designs)
    made = load_results(made_up.write(spec, formula, tmp_path / "study"))
    (spider,) = [panel for panel in panels(made, "first") if panel.polar]
    axes = figure_of(spider).axes[0]
    spokes = [label.get_text() for label in axes.get_xticklabels()]
    assert spokes == ["load", "more delay", "less delay"]
    reach = axes.lines[0].get_ydata()
    assert reach[2] == 1.0  # less delay does not hurt
    assert reach[0] == pytest.approx(0.8, abs=0.125)


def test_the_files_are_whole_and_hold_no_markup_of_strangers(place: Path, tmp_path: Path) -> None:
    said = CliRunner().invoke(
        cli, ["compare", str(place), "--html", "--latex", "--pdf", "--to", str(tmp_path)]
    )
    assert said.exit_code == 0, said.output
    assert "Success on 32 paired points" in said.output
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<b>bold" not in page
    assert "Made up &amp; &lt;b&gt;bold" in page
    assert page.count("<img") == len(panels(*write.load(place, None)))
    assert not re.findall(r'(?:src|href)="(?!data:)', page)
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF")
    latex = (tmp_path / "tables.tex").read_text(encoding="utf-8")
    assert latex.count(r"\begin{tabular}") == latex.count(r"\end{tabular}") > 4


def test_the_same_results_make_the_same_page(place: Path, tmp_path: Path) -> None:
    first, second = (
        write.write_pdf(place, tmp_path / name).read_bytes() for name in ("a.pdf", "b.pdf")
    )
    assert first == second


def test_latex_escapes_what_it_would_take_for_its_own(tmp_path: Path) -> None:
    spec = made_up.study(controllers={"first": {}}, parameters={
        "load": {"path": "x", "uniform": [0.0, 10.0], "nominal": 0.0, "unit": "%_{}"},
        "delay": {"path": "y", "uniform": [0.0, 8.0], "nominal": 0.0, "unit": "ms"},
    }, designs={"each": {"kind": "boundary", "along": "each", "steps": 2}})  # fmt: skip
    made = load_results(made_up.write(spec, formula, tmp_path / "study"))
    text = as_latex(margins(made, "each"))
    assert r"[\%\_\{\}]" in text
    assert "$>$" in text or "to" in text


def test_a_study_of_one_controller_has_no_pairs(tmp_path: Path) -> None:
    spec = made_up.study(controllers={"first": {}})
    made = load_results(made_up.write(spec, formula, tmp_path / "study"))
    titles = [table.title for table in all_tables(made, "first")]
    assert titles[0] == "Success on 16 paired points"
    assert not any("Pairs" in title for title in titles)
    write.write_pdf(tmp_path / "study", tmp_path / "page.pdf")


def test_what_is_no_study_is_told(tmp_path: Path, place: Path) -> None:
    with pytest.raises(RunLogError, match="holds no study"):
        write.load(tmp_path, None)
    with pytest.raises(InputError, match="There is no controller 'thrid'"):
        write.load(place, "thrid")
