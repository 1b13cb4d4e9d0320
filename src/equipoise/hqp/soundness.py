"""Whether the numbers of rows make sense, looked at in one pass."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import entrance


@entrance
def are_sound(A: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
    """Tell whether A [m, n] is finite and the bounds [m] leave each row a number."""
    for i in range(A.shape[0]):
        total = 0.0
        for c in range(A.shape[1]):
            total += A[i, c]  # NaN and infinity stay in a sum
        # not isfinite(): what the compiler may assume here makes that always true
        if not (abs(total) < np.inf and lower[i] <= upper[i]):
            return False
        if lower[i] == np.inf or upper[i] == -np.inf:
            return False
    return True
