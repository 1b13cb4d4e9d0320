"""How kernels are compiled, and where the compiled code is kept.

Numba keeps compiled code by the time stamp of the one file that a function stands in, and would
go on using it after a change in a file that the function calls into. Here it is kept in a folder
named after the contents of all files that a kernel of its room can be made of, in the user's cache.
"""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numba

LOG = logging.getLogger(__name__)

FAST = {"reassoc", "contract", "nsz"}
PACKAGE = Path(__file__).parent
_MARK = b"equipoise.compilation import"


@cache
def kept_in(room: Path) -> Path:
    """Return the folder for the compiled kernels of a room (folder), for exactly these sources.

    A kernel may call those of its own room and of the modules beside the rooms.
    """
    digest = hashlib.sha256()
    for path in sorted({*PACKAGE.glob("*.py"), *room.glob("*.py")}):
        source = path.read_bytes()
        if _MARK in source and path != Path(__file__):
            digest.update(source)
    home = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    base = Path(home) if home else Path.home() / ".cache"
    return base / "equipoise" / f"{room.name}-{digest.hexdigest()[:16]}"


@cache
def announce(room: Path) -> None:
    """Say once what takes so long if the kernels of a room were never compiled."""
    if not (numba.config.DISABLE_JIT or any(kept_in(room).glob("**/*.nbc"))):
        LOG.warning(
            "Compiling the kernels of %r, once and for all: about half a minute.", room.name
        )


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
    numba.config.CACHE_DIR = str(kept_in(Path(function.__code__.co_filename).parent))
    try:
        return numba.njit(cache=True, error_model="numpy", fastmath=FAST, **options)(function)
    except RuntimeError:  # nowhere to write
        return numba.njit(error_model="numpy", fastmath=FAST, **options)(function)
    finally:
        numba.config.CACHE_DIR = before
