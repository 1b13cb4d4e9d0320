"""The page in the paper's arrangement: written, not blank, and refused where there is nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.image import imread

from equipoise import run_scenario
from equipoise.analysis.figures.paper_page import write_paper_page
from equipoise.errors import InputError


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page") / "run"
    return run_scenario("telephone", out=folder, overrides=["duration=0.05"], figures=False)


def test_a_page_is_written_as_png_and_pdf(short_run, tmp_path):
    png, pdf = write_paper_page(short_run, tmp_path)
    assert png.name == "telephone_page.png"
    assert pdf.read_bytes().startswith(b"%PDF")
    pixels = imread(png)[..., :3]
    strip, plots = pixels[: pixels.shape[0] // 3], pixels[pixels.shape[0] // 2 :]
    for part in (strip, plots):
        assert len(np.unique(part.reshape(-1, 3), axis=0)) > 50


def test_a_run_without_a_readable_scenario_is_refused(short_run, tmp_path):
    with pytest.raises(InputError, match="nothing to draw"):
        write_paper_page(replace(short_run, scenario_text="name: [broken"), tmp_path)
