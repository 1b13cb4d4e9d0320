"""Memory on the stack: each array is its own, at any depth of calls, compiled or not."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from equipoise.compiled.compilation import OPTIONS
from equipoise.compiled.scratch import scratch, scratch_matrix


def inner(size: int, value: float) -> float:
    """Return the sum of a scratch array that holds `value` everywhere."""
    mine = scratch(size)
    mine[:] = value
    return mine.sum()


def filled(call, size: int, out: np.ndarray) -> None:
    """Write to out [size, 2 size] what two scratch arrays hold after somebody else used some."""
    one, two = scratch(size), scratch_matrix(size, 2 * size)
    for i in range(size):
        one[i] = i
        for k in range(2 * size):
            two[i, k] = 100.0 * i + k
    extra = call(3 * size, 7.0)
    for i in range(size):
        for k in range(2 * size):
            out[i, k] = two[i, k] + 0.001 * one[i] + extra


@pytest.mark.parametrize("size", [1, 5, 60])
def test_scratch_arrays_do_not_overlap(size: int) -> None:
    compiled = numba.njit(**OPTIONS)(filled)
    found, wanted = np.empty((size, 2 * size)), np.empty((size, 2 * size))
    compiled(numba.njit(**OPTIONS)(inner), size, found)
    filled(inner, size, wanted)
    rows, columns = np.indices(found.shape)
    assert np.allclose(found, wanted, rtol=1e-15)
    assert np.allclose(found, 100.0 * rows + columns + 0.001 * rows + 21.0 * size)


def test_a_kernel_that_allocates_does_not_compile() -> None:
    """Nobody would free what nobody counts."""
    with pytest.raises(numba.core.errors.NumbaError, match=r"(?i)nrt|returning of array"):
        numba.njit(**OPTIONS)(lambda n: np.empty(n).sum())(3)
