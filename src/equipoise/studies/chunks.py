"""How many runs a worker is given at once: for so many seconds, less where the end is near."""

from __future__ import annotations

WEIGHT = 0.05  # of a new time in the mean
TAIL = 0.5  # share of what is left for a slot that one batch may take


class ChunkSize:
    """Learns how long a run takes; `seconds` is how long a batch should take, 0 for single runs."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.mean: float | None = None

    def took(self, seconds: float) -> None:
        """Learn from a run."""
        if seconds > 0.0:
            mean = seconds if self.mean is None else self.mean
            self.mean = (1.0 - WEIGHT) * mean + WEIGHT * seconds

    def runs(self, left: int, slots: int) -> int:
        """Return how many runs the next batch has, `left` of them being without a result.

        Toward the end batches become smaller, so that all slots end at about the same time
        (guided self-scheduling, Polychronopoulos and Kuck 1987).
        """
        if self.mean is None or self.seconds == 0.0:
            return 1
        share = TAIL * left / max(slots, 1)
        return max(1, int(min(self.seconds / self.mean, share)))
