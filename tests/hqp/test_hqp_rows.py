"""Rows refuse what no solver should see, and say which row it was."""

from __future__ import annotations

import numpy as np
import pytest
from hqp_problems import block

from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.hqp import Hierarchy, Rows


def make(A=None, lower=None, upper=None) -> Rows:
    A = np.eye(3) if A is None else A
    return Rows(
        "left hand",
        "m/s",
        ("x", "y", "z"),
        A,
        -np.ones(3) if lower is None else lower,
        np.ones(3) if upper is None else upper,
    )


def test_sound_rows_pass() -> None:
    make(lower=np.array([-np.inf, 0.0, 0.0]), upper=np.array([np.inf, np.inf, 0.0])).check()


@pytest.mark.parametrize(
    "given",
    [
        {"A": np.eye(2)},
        {"A": np.ones(3)},
        {"lower": np.zeros(2)},
        {"upper": np.zeros((3, 1))},
    ],
)
def test_wrong_shapes_are_refused_at_once(given) -> None:
    with pytest.raises(ShapeError, match="left hand"):
        make(**given)


def spoil(array: np.ndarray, index, value: float) -> np.ndarray:
    array = array.copy()
    array[index] = value
    return array


@pytest.mark.parametrize("stacked", [False, True])
@pytest.mark.parametrize(
    ("error", "given"),
    [
        (NonFiniteError, {"A": spoil(np.eye(3), (1, 2), np.nan)}),
        (NonFiniteError, {"A": spoil(np.eye(3), (1, 0), np.inf)}),
        (NonFiniteError, {"lower": spoil(-np.ones(3), 1, np.nan)}),
        (NonFiniteError, {"upper": spoil(np.ones(3), 1, np.nan)}),
        (
            NonFiniteError,
            {"lower": spoil(-np.ones(3), 1, np.inf), "upper": spoil(np.ones(3), 1, np.inf)},
        ),
        (
            NonFiniteError,
            {"lower": spoil(-np.ones(3), 1, -np.inf), "upper": spoil(np.ones(3), 1, -np.inf)},
        ),
        (InputError, {"lower": spoil(-np.ones(3), 1, 1.5)}),
    ],
)
def test_unsound_values_are_refused_by_name(error, given, stacked) -> None:
    rows = make(**given)
    good = block("good", np.eye(3), -np.ones(3), np.ones(3))
    meet = (lambda: Hierarchy.stack([[good], [rows]], 3)) if stacked else rows.check
    with pytest.raises(error, match=r"row 'y' of rows 'left hand'"):
        meet()
