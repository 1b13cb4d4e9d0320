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
from numba.core.options import DefaultOptions

LOG = logging.getLogger(__name__)

FAST = {"reassoc", "contract", "nsz"}
# no reference counts: arrays outlive kernels, and counting takes a fifth of their time. Kernels
# cannot allocate for that, see `scratch`
UNCOUNTED = {"_nrt": False} if hasattr(DefaultOptions, "_nrt") else {}
OPTIONS = {"error_model": "numpy", "fastmath": FAST, **UNCOUNTED}
PACKAGE = Path(__file__).parents[1]
_MARKS = (b"\n@compiled\n", b"\n@entrance\n", b"\n@inlined\n")
_HOW = Path(__file__), Path(__file__).with_name("scratch.py")  # how they are compiled
_announced = False


@cache
def kernel_files() -> tuple[Path, ...]:
    """Return every file of the package that has kernels."""
    return tuple(p for p in sorted(PACKAGE.rglob("*.py")) if _has_kernels(p.read_bytes()))


@cache
def kept_in(room: Path) -> Path:
    """Return the folder for the compiled kernels of a room (folder), for exactly these sources.

    Kernels may call those of other rooms and take constants from their neighbours.
    """
    digest = hashlib.sha256()
    for path in sorted({*room.glob("*.py"), *kernel_files(), *_HOW}):
        digest.update(path.read_bytes())
    home = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    base = Path(home) if home else Path.home() / ".cache"
    return base / "equipoise" / f"{room.name}-{digest.hexdigest()[:16]}"


def announce(room: Path | None = None) -> None:
    """Say, once a process, what takes so long if kernels (of one room) were never compiled."""
    global _announced
    if _announced or numba.config.DISABLE_JIT:
        return
    wanted = {path.parent for path in kernel_files()} if room is None else {room}
    if not all(any(kept_in(one).glob("**/*.nbc")) for one in wanted):
        LOG.warning("Compiling kernels, once and for all: one to two minutes of one core.")
        _announced = True


def _has_kernels(source: bytes) -> bool:
    return any(mark in source for mark in _MARKS)


def compiled(function: Callable) -> Callable:
    """Compile a kernel that only kernels call, and keep the result."""
    return _kept(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def entrance(function: Callable) -> Callable:
    """Compile a kernel that Python calls, and keep the result."""
    return _kept(function)


def inlined(function: Callable) -> Callable:
    """Compile a small kernel, or one with one caller, into the kernels that call it."""
    return numba.njit(inline="always", **OPTIONS)(function)


def _kept(function: Callable, **options: bool) -> Callable:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(kept_in(Path(function.__code__.co_filename).parent))
    try:
        return numba.njit(cache=True, **OPTIONS, **options)(function)
    except RuntimeError:  # nowhere to write
        return numba.njit(**OPTIONS, **options)(function)
    finally:
        numba.config.CACHE_DIR = before
