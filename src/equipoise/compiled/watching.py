"""Says when kernels are compiled rather than loaded, which takes a minute and happens once."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

LOG = logging.getLogger(__name__)
COST = "one to two minutes"
PACKAGE = __name__.partition(".")[0]


class _Compilations(event.Listener):  # type: ignore[misc]  # numba has no types
    """Tells the watcher, or warns once where nobody watches, that a kernel of ours is compiled."""

    def __init__(self) -> None:
        self.watcher: Callable[[bool], None] | None = None
        self._depth = 0
        self._warned = False

    def on_start(self, begun: event.Event) -> None:
        """Note that numba begins to compile; kernels call others, which are compiled within."""
        if self._depth or _is_ours(begun):
            self._depth += 1
        if self._depth != 1:
            return
        if self.watcher is not None:
            self.watcher(True)
        elif not self._warned:
            self._warned = True
            LOG.warning("Compiling kernels, which is done once: %s of one core.", COST)

    def on_end(self, done: event.Event) -> None:
        """Note that numba is done with one."""
        if not self._depth:
            return
        self._depth -= 1
        if not self._depth and self.watcher is not None:
            self.watcher(False)


def _is_ours(begun: event.Event) -> bool:
    function: Any = begun.data["dispatcher"].py_func
    return function.__module__.partition(".")[0] == PACKAGE


_COMPILATIONS = _Compilations()
event.register("numba:compile", _COMPILATIONS)


@contextmanager
def watch_compilation(tell: Callable[[bool], None]) -> Iterator[None]:
    """Call `tell(True)` when a kernel begins to be compiled, and `tell(False)` when that is done.

    What was compiled before and is kept is loaded without a word.
    """
    before, _COMPILATIONS.watcher = _COMPILATIONS.watcher, tell
    try:
        yield
    finally:
        _COMPILATIONS.watcher = before
