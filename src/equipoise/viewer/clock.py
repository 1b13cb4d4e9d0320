"""Where a replay stands in time: playing or not, how fast, and what was asked for."""

from __future__ import annotations

import threading

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)


class Clock:
    """Time of a replay between `first` and `last` [s]; safe to steer from other threads."""

    def __init__(self, first: float, last: float) -> None:
        self.first, self.last = first, last
        self._t, self._playing, self._speed = first, False, 1.0
        self._lock = threading.Lock()
        self._asked = threading.Event()

    @property
    def t(self) -> float:
        """The present time [s]."""
        return self._t

    @property
    def playing(self) -> bool:
        """Whether time goes on by itself."""
        return self._playing

    def play(self, playing: bool) -> None:
        """Let time go on or stand; at the end it begins anew."""
        with self._lock:
            if playing and self._t >= self.last:
                self._t = self.first
            self._playing = playing
        self._asked.set()

    def toggle(self) -> None:
        """Let time go on if it stands, and stand if it goes on."""
        with self._lock:
            self._playing = not self._playing
            if self._playing and self._t >= self.last:
                self._t = self.first
        self._asked.set()

    def set_speed(self, speed: float) -> None:
        """Set how many seconds of the run pass in one second."""
        with self._lock:
            self._speed = speed

    def seek(self, t: float) -> None:
        """Go to time `t` [s], or to the nearest there is."""
        with self._lock:
            self._t = min(max(t, self.first), self.last)
        self._asked.set()

    def advance(self, elapsed: float) -> None:
        """Let `elapsed` [s] of real time pass; at the end it stands."""
        with self._lock:
            if not self._playing:
                return
            self._t += elapsed * self._speed
            if self._t >= self.last:
                self._t, self._playing = self.last, False

    def wait(self, seconds: float) -> None:
        """Sleep, but not longer than until something is asked."""
        self._asked.wait(seconds)
        self._asked.clear()
