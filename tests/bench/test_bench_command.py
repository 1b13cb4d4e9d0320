"""`equipoise bench` as a person meets it: exit codes, sentences, the file."""

from __future__ import annotations

import json
import os
import subprocess
import sys

from equipoise.bench import Row, write_rows


def bench(*arguments: str, cwd, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "equipoise", "bench", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env=os.environ | environment,
    )


def test_a_spoiled_comparison_ends_with_1_and_the_rows_are_written(tmp_path):
    """The kept file claims a tick a thousand times faster than DAQP."""
    kept = [Row("tick/hrp2/tray", 0.1, 0.1), Row("daqp/hrp2/tray", 100.0, 100.0)]
    write_rows(tmp_path / "kept.json", kept)
    done = bench(
        "--quick", "--json", "rows.json", "--compare", "kept.json",
        cwd=tmp_path, OMP_NUM_THREADS="4",
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert "worse by more than a third" in done.stdout
    rows = {row["name"]: row for row in json.loads((tmp_path / "rows.json").read_text())}
    for name in ("tick/hrp2/tray", "hqp/hrp2/tray", "rigid/hrp2/tray", "daqp/hrp2/hard"):
        assert rows[name]["median_us"] > 0.0
        assert rows[name]["p99_us"] >= rows[name]["median_us"]
    assert "placo is left out" in done.stderr


def test_wrong_input_ends_with_2_and_one_message(tmp_path):
    done = bench("--quick", "--json", "no/such/folder/rows.json", cwd=tmp_path)
    assert done.returncode == 2, done.stdout
    assert "cannot write" in done.stderr
    assert "Traceback" not in done.stderr
