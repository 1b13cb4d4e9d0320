"""How kernels are compiled, and where the compiled code is kept.

Numba keeps compiled code by the time stamp of the one file that a function stands in, and would
go on using it after a change in a file that the function calls into. Here it is kept in a folder
named after the contents of all files of the room, in the user's cache.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path

import numba

FAST = {"reassoc", "contract", "nsz"}


def kept_in() -> Path:
    """Return the folder for the compiled kernels of exactly these sources."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*kernels.py")):
        digest.update(path.read_bytes())
    home = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    base = Path(home) if home else Path.home() / ".cache"
    return base / "equipoise" / f"kernels-{digest.hexdigest()[:16]}"


FOLDER = kept_in()


def is_kept() -> bool:
    """Tell whether compiled kernels of these sources are there, or none are needed."""
    return bool(numba.config.DISABLE_JIT) or any(FOLDER.glob("**/*.nbc"))


def compiled(function: Callable) -> Callable:
    """Compile a kernel that only kernels call, and keep the result."""
    return _kept(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def entrance(function: Callable) -> Callable:
    """Compile a kernel that Python calls, and keep the result."""
    return _kept(function)


def inlined(function: Callable) -> Callable:
    """Compile a small kernel, or one with one caller, into the kernels that call it."""
    return numba.njit(inline="always", error_model="numpy", fastmath=FAST)(function)


def _kept(function: Callable, **options: bool) -> Callable:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(FOLDER)
    try:
        return numba.njit(cache=True, error_model="numpy", fastmath=FAST, **options)(function)
    except RuntimeError:  # nowhere to write
        return numba.njit(error_model="numpy", fastmath=FAST, **options)(function)
    finally:
        numba.config.CACHE_DIR = before
