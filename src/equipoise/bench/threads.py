"""One thread for every library, said before any of them is loaded."""

from __future__ import annotations

import os
import sys

from equipoise.errors import InputError

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def pin_threads() -> None:
    """Keep every library at one thread; must come before numpy is loaded.

    Raises: `InputError` if it is too late.
    """
    unpinned = [name for name in THREADS if os.environ.get(name) != "1"]
    if unpinned and "numpy" in sys.modules:
        raise InputError(
            "numpy is loaded already, with more than one thread",
            given=unpinned,
            remedy=f"Start Python with {' '.join(f'{name}=1' for name in unpinned)}",
        )
    os.environ.update(dict.fromkeys(THREADS, "1"))
