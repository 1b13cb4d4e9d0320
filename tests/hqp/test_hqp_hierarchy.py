"""A hierarchy keeps its rows in order, prints, and survives the disk."""

from __future__ import annotations

import numpy as np
import pytest
from hqp_problems import KINDS, block, equalities, random_hierarchy

from equipoise.errors import InputError, ShapeError
from equipoise.hqp import Hierarchy, load_problem, save_problem


def three_levels() -> Hierarchy:
    rng = np.random.default_rng(1)
    feet = equalities("feet", rng.normal(size=(6, 7)), np.zeros(6))
    box = block("limits", np.eye(7)[:4], -np.ones(4), np.array([1.0, 1.0, np.inf, 1.0]), "rad/s")
    idle = block("idle", np.ones((1, 7)), np.array([-np.inf]), np.array([np.inf]))
    hand = equalities("hand", rng.normal(size=(3, 7)), np.ones(3))
    return Hierarchy.stack([[feet], [box, idle], [], [hand]], 7)


def test_rows_stand_in_order_and_levels_are_slices() -> None:
    h = three_levels()
    assert h.ends == (6, 11, 11, 14)
    assert [h.level(i) for i in range(4)] == [
        slice(0, 6),
        slice(6, 11),
        slice(11, 11),
        slice(11, 14),
    ]
    assert [b.name for b in h.blocks] == ["feet", "limits", "idle", "hand"]
    assert np.array_equal(h.A[h.blocks[1].rows], np.eye(7)[:4])
    assert h.name_of(8) == "limits/limits2"
    assert h.block_of(13).name == "hand"


def test_it_prints_every_block_with_its_unit() -> None:
    text = str(three_levels())
    for part in ("4 levels", "14 rows", "feet", "6 equal", "4 bounded", "1 free", "rad/s"):
        assert part in text


def test_a_block_of_another_width_is_refused() -> None:
    with pytest.raises(ShapeError, match="narrow"):
        Hierarchy.stack([[equalities("narrow", np.eye(2), np.zeros(2))]], 3)


def test_a_missing_level_or_row_is_refused() -> None:
    h = three_levels()
    with pytest.raises(InputError, match="Levels are 0 to 3"):
        h.level(4)
    with pytest.raises(InputError, match="Rows are 0 to 13"):
        h.name_of(14)


@pytest.mark.parametrize("kind", KINDS)
def test_it_comes_back_from_the_disk_as_it_was(kind, tmp_path) -> None:
    h = random_hierarchy(kind, 3)
    save_problem(tmp_path / "problem.npz", h)
    back = load_problem(tmp_path / "problem.npz").hierarchy
    assert np.array_equal(h.A, back.A)
    assert np.array_equal(h.lower, back.lower)
    assert np.array_equal(h.upper, back.upper)
    assert (h.ends, h.blocks) == (back.ends, back.blocks)


def test_another_file_is_refused_kindly(tmp_path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, x=np.zeros(2))
    with pytest.raises(InputError, match="save_problem"):
        load_problem(path)


def test_nothing_is_a_hierarchy_too() -> None:
    h = Hierarchy.stack([], 4)
    assert h.A.shape == (0, 4)
    assert h.ends == ()
