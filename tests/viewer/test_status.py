"""Mode and status in words: the line beside the picture, and the report's sentences."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.analysis.report.modes import modes_sentence, status_sentence
from equipoise.contacts import Phase
from equipoise.control import Mode
from equipoise.runlog import Channel, Run, RunWriter, load_run
from equipoise.simulation.recorder import MODE_CODES
from equipoise.viewer.layer import Moment
from equipoise.viewer.status_line import status_html


def _moment(**values: list[float]) -> Moment:
    arrays = {name: np.array(numbers) for name, numbers in values.items()}
    return Moment(0.0, arrays, SimpleNamespace())


@pytest.mark.parametrize("mode", list(Mode))
def test_every_mode_has_its_word(mode: Mode) -> None:
    said = status_html(_moment(mode=[MODE_CODES[mode]], status=[0.0, 0.0]))
    assert mode.name.lower() in said
    assert ("700" in said) == (mode is not Mode.RUN)


def test_a_code_of_another_version_is_said_and_old_logs_have_no_line() -> None:
    assert "unknown (9)" in status_html(_moment(mode=[9.0]))
    assert "supervisor" not in status_html(_moment())


def test_how_feet_are_is_said_and_what_nobody_planned_is_bold() -> None:
    said = status_html(_moment(**{"walk/phase": [Phase.HELD.code, Phase.FREE.code]}))
    assert "left foot" in said
    assert "held" in said
    assert "free" in said
    assert "700" not in said
    said = status_html(_moment(**{"walk/phase": [Phase.LOST.code, Phase.HELD.code]}))
    assert said.count("700") == 1
    assert "lost" in said


def _run(folder: Path, modes: list[float]) -> Run:
    channels = [
        Channel("mode", ("supervisor",), ""),
        Channel("status", ("control", "hierarchy"), ""),
    ]
    with RunWriter(folder, channels, scenario_text="", seed=0) as writer:
        for k, mode in enumerate(modes):
            status = np.array([float(k == 1), 0.0])
            writer.write(0.5 * k, {"mode": np.array([mode]), "status": status})
    return load_run(folder)


def test_the_report_says_when_the_mode_changed(tmp_path: Path) -> None:
    run = _run(tmp_path / "changed", [0.0, 0.0, 2.0, 3.0])
    said = modes_sentence(run)
    assert said == "Supervisor: run from 0.000 s, safe from 1.000 s, stopped from 1.500 s."
    assert "law saturated on 25 %" in status_sentence(run)
    calm = _run(tmp_path / "calm", [0.0])
    assert modes_sentence(calm) == "Supervisor: run throughout."
    assert "well on every tick" in status_sentence(calm)
