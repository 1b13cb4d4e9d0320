"""Rows in files, ratios, and the comparison with kept ones."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
from pathlib import Path

import pytest

from equipoise.bench import Row, read_rows, write_rows
from equipoise.bench.compare import compare, ratios
from equipoise.bench.interleave import row_of
from equipoise.errors import InputError

ROWS = [
    Row("tick/hrp2/tray", 70.0, 90.0, 100),
    Row("tick/hrp2/law", 20.0, 30.0, 100),
    Row("hqp/hrp2/tray", 20.0, 30.0, 100),
    Row("daqp/hrp2/tray", 40.0, 60.0, 100),
    Row("hqp/hrp2/hard", 50.0, 90.0, 100),
    Row("daqp/hrp2/hard", 60.0, 90.0, 100, failures=1),
    Row("peer/pink/hrp2", 350.0, 500.0, 100, remark="a version"),
    Row("peer/pink/talos", 340.0, 500.0, 100),
    Row("growth/rows/50", 40.0, 50.0, 100),
]


def changed(factor: float, *names: str) -> list[Row]:
    """Return the rows with the times of those that are named multiplied (of all without names)."""
    return [
        dataclasses.replace(row, median_us=factor * row.median_us, p99_us=factor * row.p99_us)
        if not names or row.name in names
        else row
        for row in ROWS
    ]


def test_rows_come_back_from_their_file(tmp_path):
    write_rows(tmp_path / "rows.json", ROWS)
    assert read_rows(tmp_path / "rows.json") == ROWS
    plain = json.loads((tmp_path / "rows.json").read_text())
    assert plain[0]["name"] == "tick/hrp2/tray"
    assert plain[0]["median_us"] == 70.0
    assert plain[0]["p99_us"] == 90.0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{}",
        "[1]",
        '[{"name": "a"}]',
        '[{"name": "a", "median_us": 0, "p99_us": 1}]',
        '[{"name": "a", "median_us": "fast", "p99_us": 1}]',
        '[{"name": "a", "median_us": NaN, "p99_us": 1}]',
    ],
)
def test_a_file_of_something_else_is_refused(tmp_path, text):
    path = tmp_path / "rows.json"
    path.write_text(text)
    with pytest.raises(InputError, match="equipoise bench"):
        read_rows(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"nothing\.json"):
        read_rows(tmp_path / "nothing.json")


def test_ratios_stay_with_their_robot_and_their_case():
    found = {(r.ours, r.other): r.value for r in ratios(ROWS)}
    assert found["tick/hrp2/tray", "peer/pink/hrp2"] == pytest.approx(0.2)
    assert found["hqp/hrp2/hard", "daqp/hrp2/hard"] == pytest.approx(5 / 6)
    assert found["tick/hrp2/law", "daqp/hrp2/tray"] == pytest.approx(0.5)
    assert not any("talos" in other for _, other in found)
    assert ("hqp/hrp2/tray", "peer/pink/hrp2") not in found


def test_a_slower_machine_changes_nothing():
    assert all(change.passed for change in compare(changed(7.0), ROWS))


def test_a_third_worse_is_found_and_named():
    slower = changed(1.4, "hqp/hrp2/hard")
    worse = [change for change in compare(slower, ROWS) if not change.passed]
    assert [change.now.ours for change in worse] == ["hqp/hrp2/hard"]
    assert "worse by more than a third" in str(worse[0])
    assert all(change.passed for change in compare(changed(1.3, "hqp/hrp2/hard"), ROWS))
    assert all(change.passed for change in compare(changed(0.2, "hqp/hrp2/hard"), ROWS))


def test_nothing_in_common_is_an_error():
    with pytest.raises(InputError, match="no ratio in common"):
        compare(ROWS, [Row("tick/talos/tray", 1.0, 1.0), Row("daqp/talos/tray", 1.0, 1.0)])


def test_median_and_tail_are_those_of_the_times():
    row = row_of("a", [1000 * k for k in range(1, 102)])
    assert (row.median_us, row.p99_us, row.ticks) == (51.0, 100.0, 101)


def test_the_page_shows_the_kept_results():
    place = Path(__file__).parents[2] / "docs" / "benchmark_tables.py"
    spec = importlib.util.spec_from_file_location("benchmark_tables", place)
    tables = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tables)
    text = tables.PAGE.read_text(encoding="utf-8")
    assert text == tables.filled(text, read_rows(tables.KEPT)), (
        "docs/benchmarks.md is old: run python docs/benchmark_tables.py"
    )
