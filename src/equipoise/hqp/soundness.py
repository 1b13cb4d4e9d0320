"""Whether the numbers of rows make sense, looked at in one pass.

Coefficients and bounds have to be finite and of a size whose squares a double holds. Inside a level
the violations of all rows add up to one sum of squares, in which a row counts with the square of
its length: a row shorter than the longest by LENGTHS_APART leaves no digits of its own there.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, entrance

LARGEST_ROW, SMALLEST_ROW = 1e50, 1e-50  # length of a row of A that is not zero
LARGEST_BOUND = 1e100
LENGTHS_APART = 1e8  # longest over shortest row of a level, rows without bounds and of zeros apart


@compiled
def length_if_sound(A: np.ndarray, lower: np.ndarray, upper: np.ndarray, row: int) -> float:
    """Return the length of a row of A [m, n], or -1 if it or its bounds make no sense."""
    squares, total = 0.0, 0.0
    for c in range(A.shape[1]):
        squares += A[row, c] * A[row, c]  # NaN and infinity stay in a sum
        total += abs(A[row, c])
    low, high = lower[row], upper[row]
    # not isfinite(): what the compiler may assume here makes that always true
    if not (squares <= LARGEST_ROW**2 and low <= high):
        return -1.0
    if squares < SMALLEST_ROW**2 and total > 0.0:
        return -1.0
    if low > LARGEST_BOUND or high < -LARGEST_BOUND:
        return -1.0
    if (low < -LARGEST_BOUND and low > -np.inf) or (high > LARGEST_BOUND and high < np.inf):
        return -1.0
    return np.sqrt(squares)


@entrance
def are_sound(A: np.ndarray, lower: np.ndarray, upper: np.ndarray, ends: np.ndarray) -> bool:
    """Tell whether A [m, n] and the bounds [m] make sense, in levels that end at `ends`."""
    start = 0
    for level in range(ends.shape[0]):
        shortest, longest = np.inf, 0.0
        for row in range(start, ends[level]):
            length = length_if_sound(A, lower, upper, row)
            if length < 0.0:
                return False
            if length > 0.0 and not (lower[row] == -np.inf and upper[row] == np.inf):
                shortest, longest = min(shortest, length), max(longest, length)
        if longest > LENGTHS_APART * shortest:
            return False
        start = ends[level]
    return True
