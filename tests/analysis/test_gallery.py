"""The gallery is made by code: in a small form here, and its pictures show something."""

from __future__ import annotations

import re
import runpy
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PIL", reason="needs the extra 'plot': pip install -e '.[plot]'")

DOCS = Path(__file__).parents[2] / "docs"


def test_the_gallery_is_made_and_no_picture_is_blank(tmp_path: Path) -> None:
    from PIL import Image

    make = runpy.run_path(str(DOCS / "make_gallery.py"))
    make["main"](["--small", "--to", str(tmp_path), "--runs", str(tmp_path / "runs")])
    pictures = [np.asarray(Image.open(p).convert("RGB")) for p in sorted(tmp_path.glob("*.png"))]
    assert len(pictures) == len(make["SMALL"])
    for one in pictures:
        width, height = make["SMALL_SIZE"]
        assert one.shape == (height, width, 3)
        _, counts = np.unique(one.reshape(-1, 3), axis=0, return_counts=True)
        assert counts.max() < 0.5 * counts.sum()
        middle = one[height // 4 : -height // 4, width // 4 : -width // 4]
        assert middle.std(axis=(0, 1)).min() > 15.0  # a robot before floor and sky
    for one, other in pairwise(pictures):
        assert np.abs(one.astype(int) - other).mean() > 2.0


def test_every_picture_of_the_page_is_there_and_shows_something() -> None:
    from PIL import Image

    names = re.findall(r"\(images/([^)]+)\)", (DOCS / "gallery.md").read_text())
    assert len(names) > 10
    for name in names:
        with Image.open(DOCS / "images" / name) as picture:
            seen = np.asarray(picture.convert("L"))
        assert min(seen.shape) > 200, name
        assert seen.std() > 10.0, name
