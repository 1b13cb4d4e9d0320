"""The page on walking shows the results that are kept."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path


def test_the_page_shows_the_kept_results():
    place = Path(__file__).parents[2] / "docs" / "walking_tables.py"
    spec = importlib.util.spec_from_file_location("walking_tables", place)
    tables = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = tables
    spec.loader.exec_module(tables)
    text = tables.PAGE.read_text(encoding="utf-8")
    rows = [json.loads(line) for line in tables.KEPT.read_text(encoding="utf-8").splitlines()]
    assert text == tables.page(), "docs/walking.md is old: run docs/walking_tables.py"
    assert {row["robot"] for row in rows} == set(tables.ROBOTS)
