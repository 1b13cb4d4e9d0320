"""How kernels are compiled, and where the compiled code is kept.

Numba keeps compiled code by the time stamp of the one file that a function stands in, and would
go on using it after a change in a file that the function calls into. Here it is kept in a folder
named after the contents of all files that a kernel of its room can be made of, in the user's cache,
and only if that folder is the user's alone: code that is loaded is code that is run.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, ParamSpec, TypeVar

import numba
from numba import types
from numba.core.options import DefaultOptions

from equipoise.compiled.own_folder import own_folder, tell_untrusted

Kernel = TypeVar("Kernel", bound=Callable[..., Any])  # a kernel keeps its signature when compiled
P = ParamSpec("P")
R = TypeVar("R")

FAST = {"reassoc", "contract", "nsz"}
# no reference counts: arrays outlive kernels, and counting takes a fifth of their time. Kernels
# cannot allocate for that, see `scratch`
UNCOUNTED = {"_nrt": False} if hasattr(DefaultOptions, "_nrt") else {}
OPTIONS = {"error_model": "numpy", "fastmath": FAST, **UNCOUNTED}
PACKAGE = Path(__file__).parents[1]
_MARKS = (b"\n@compiled\n", b"\n@entrance\n", b"\n@inlined\n")
_HOW = Path(__file__), Path(__file__).with_name("scratch.py")  # how they are compiled


@cache
def kernel_files() -> tuple[Path, ...]:
    """Return every file of the package that has kernels."""
    return tuple(p for p in sorted(PACKAGE.rglob("*.py")) if _has_kernels(p.read_bytes()))


@cache
def kept_in(room: Path) -> Path:
    """Return the folder for the compiled kernels of a room (folder), for exactly these sources.

    Those are its files and all that they import, since kernels call those of other rooms and take
    constants from them.
    """
    digest = hashlib.sha256()
    for path in sorted({*_reached_from(tuple(sorted(room.glob("*.py")))), *_HOW}):
        digest.update(_digest_of(path))
    return _cache() / f"{room.name}-{digest.hexdigest()[:16]}"


def _cache() -> Path:
    home = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    base = Path(home) if home else Path.home() / ".cache"
    return base / "equipoise"


@cache
def is_kept() -> bool:
    """Say whether compiled code is kept: only in a folder that is the user's alone."""
    why = own_folder(_cache())
    if why:
        tell_untrusted(why)
    return not why


def _reached_from(files: tuple[Path, ...]) -> set[Path]:
    """Return these files of the package and all that they import, one by way of another."""
    reached: set[Path] = set()
    waiting = list(files)
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached.add(path)
            waiting += _imported_by(path)
    return reached


@cache
def _imported_by(path: Path) -> tuple[Path, ...]:
    """Return the files of the package whose names a file takes."""
    found = []
    for module in re.findall(r"^from equipoise\.([\w.]+) import", path.read_text("utf-8"), re.M):
        place = PACKAGE.joinpath(*module.split("."))
        found += [p for p in (place.with_suffix(".py"), place / "__init__.py") if p.is_file()]
    return tuple(found)


@cache
def _digest_of(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


def _has_kernels(source: bytes) -> bool:
    return any(mark in source for mark in _MARKS)


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel that only kernels call, and keep the result."""
    return _kept(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def entrance(function: Kernel) -> Kernel:
    """Compile a kernel that Python calls, and keep the result."""
    return _kept(function)


def inlined(function: Kernel) -> Kernel:
    """Compile a small kernel, or one with one caller, into the kernels that call it.

    Where Python calls it, it is compiled by itself, and kept.
    """
    return _cached(function, inline="always")


@contextmanager
def kept_where(room: Path) -> Iterator[None]:
    """Let numba keep what it compiles meanwhile in the folder of a room."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(kept_in(room))
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


def _kept(function: Kernel, **options: bool) -> Kernel:
    kernel = _cached(function, **options)
    if is_kept() and not numba.config.DISABLE_JIT:
        _compile_once(kernel)
    return kernel


def _cached(function: Kernel, **options: bool | str) -> Kernel:
    """Compile a function, and keep the result where there is a place for it."""
    kernel: Kernel
    if not is_kept():
        kernel = numba.njit(**OPTIONS, **options)(function)
        return kernel
    try:
        with kept_where(Path(function.__code__.co_filename).parent):
            kernel = numba.njit(cache=True, **OPTIONS, **options)(function)
    except RuntimeError:  # nowhere to write
        kernel = numba.njit(**OPTIONS, **options)(function)
    return kernel


def _compile_once(kernel: Any) -> None:
    """Let a kernel be compiled once, not again for every constant that another calls it with.

    Numba takes `reduce(0)` and `reduce(start)` for calls with different types, and would compile a
    third of the solver twice.
    """
    ask = kernel.get_call_template

    def without_constants(args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        return ask(
            tuple(map(types.unliteral, args)), {k: types.unliteral(a) for k, a in kws.items()}
        )

    kernel.get_call_template = without_constants


def specialised(template: Callable[P, R], name: str, **names: Any) -> Callable[P, R]:
    """Return a copy of a function that finds other things under some of its global names.

    Compiled, each copy is kept under its own `name`. A closure would do the same, but what numba
    keeps of closures is never found again.
    """
    given = {**template.__globals__, **names}
    made = FunctionType(template.__code__, given, name, template.__defaults__)
    made.__qualname__, made.__annotations__ = name, template.__annotations__
    return made
