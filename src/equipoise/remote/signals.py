"""Ctrl-C and SIGTERM: the first asks for an orderly end, the second ends at once."""

from __future__ import annotations

import signal
from types import FrameType
from typing import Any

NAMES = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM"}


class StopSignals:
    """Takes both signals from `take` to `give_back`; outside of the main thread it takes none.

    `cause` says in words who asked for the end, empty if nobody did. Who does not look at it yet
    (`asked` was never called), or was asked before, is interrupted: `KeyboardInterrupt`.
    """

    def __init__(self) -> None:
        self.cause, self._looked = "", False
        self._before: dict[signal.Signals, Any] = {}

    def take(self) -> None:
        """Take the signals from now on."""
        for number in NAMES:
            try:
                self._before[number] = signal.signal(number, self._asked)
            except ValueError:  # not in the main thread
                return

    def give_back(self) -> None:
        """Let them do what they did before; twice does no harm."""
        while self._before:
            number, before = self._before.popitem()
            signal.signal(number, before)

    def asked(self) -> str:
        """Return who asks for the end, empty if nobody does."""
        self._looked = True
        return self.cause

    def _asked(self, number: int, frame: FrameType | None) -> None:
        again, self.cause = bool(self.cause), NAMES[signal.Signals(number)]
        if again or not self._looked:
            raise KeyboardInterrupt
