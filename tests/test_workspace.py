"""The workspace: arrays lie apart, kernels and Python see the same, its state comes back."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.compiled import entrance
from equipoise.compiled.workspace import (
    LINE,
    Arrays,
    Workspace,
    integer_matrix,
    integers,
    matrix,
    part_of,
    vector,
)

ARRAYS = Arrays(("x", "m", "count", "pairs"), frozenset({"count", "pairs"}))
X, M, COUNT, PAIRS = range(4)


@entrance
def write(floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, number: int) -> None:
    part = part_of(floats, whole, tables, number)
    x, m = vector(part, X), matrix(part, M)
    for i in range(x.shape[0]):
        x[i] = i + 0.5
    for i in range(m.shape[0]):
        for c in range(m.shape[1]):
            m[i, c] = 10 * i + c
    count, pairs = integers(part, COUNT), integer_matrix(part, PAIRS)
    for i in range(count.shape[0]):
        count[i] = -i
    pairs[1, 0] = 7


def made() -> Workspace:
    small = ARRAYS.shapes(x=3, m=(2, 5), count=4, pairs=(3, 2))
    large = ARRAYS.shapes(x=9, m=(4, 1), count=1, pairs=(2, 2))
    return Workspace({"small": small, "large": large}, memory=("small.x", "large.pairs"))


def test_kernels_and_python_see_the_same_numbers():
    workspace = made()
    write(workspace.floats, workspace.integers, workspace.tables, 1)
    large = workspace.large
    assert np.array_equal(large.x, np.arange(9) + 0.5)
    assert np.array_equal(large.m[:, 0], [0.0, 10.0, 20.0, 30.0])
    assert np.array_equal(large.count, [0])
    assert np.array_equal(large.pairs, [[0, 0], [7, 0]])
    assert not any(getattr(workspace.small, name).any() for name in workspace.small)


def test_arrays_lie_apart_and_begin_at_cache_lines():
    workspace = made()
    for part in workspace.parts.values():
        for name in part:
            view = getattr(part, name)
            view[...] = 1
    assert workspace.floats.ctypes.data % (8 * LINE) == 0
    sizes = [getattr(p, n).size for p in workspace.parts.values() for n in p]
    assert int(workspace.floats.sum() + workspace.integers.sum()) == sum(sizes)
    assert (workspace.tables[:, :, 0] % LINE == 0).all()


def test_the_state_is_a_copy_that_comes_back():
    workspace = made()
    workspace.small.x[:] = [1.0, 2.0, 3.0]
    kept = workspace.memory()
    workspace.small.x[:] = 0.0
    workspace.large.pairs[0, 0] = 5
    assert list(kept["small.x"]) == [1.0, 2.0, 3.0]
    workspace.restore(kept)
    assert list(workspace.small.x) == [1.0, 2.0, 3.0]
    assert workspace.large.pairs[0, 0] == 0


def test_a_shape_left_out_is_told():
    with pytest.raises(AssertionError, match="missing: \\['pairs'\\]"):
        ARRAYS.shapes(x=1, m=(1, 1), count=1)
    with pytest.raises(AttributeError):
        _ = made().small.nothing
