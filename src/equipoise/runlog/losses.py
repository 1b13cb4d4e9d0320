"""What of a log could not be read, in words."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

TOLD = 4  # gaps that a note names


@dataclass
class Losses:
    """What of a log could not be read: chunks that are spoilt, and gaps in the ticks' numbers."""

    chunks: int = 0
    gaps: list[tuple[int, float, float]] = field(default_factory=list)  # ticks, between [s]
    at_end: int = 0
    misplaced: int = 0
    pictures: int = 0

    def __bool__(self) -> bool:
        return bool(self.chunks or self.gaps or self.at_end or self.misplaced or self.pictures)

    def sentence(self, name: str) -> str:
        """Say what is missing, "" if nothing is."""
        parts = []
        if self.chunks:
            parts.append(f"{self.chunks} chunk{'s' * (self.chunks > 1)} had to be left out")
        for ticks, before, after in self.gaps[:TOLD]:
            since = f"between t = {before:.6g} s and" if np.isfinite(before) else "before"
            parts.append(f"{_ticks(ticks)} missing {since} t = {after:.6g} s")
        if len(self.gaps) > TOLD:
            more = sum(ticks for ticks, _, _ in self.gaps[TOLD:])
            parts.append(f"{_ticks(more)} missing in {len(self.gaps) - TOLD} more places")
        if self.at_end:
            parts.append(f"{_ticks(self.at_end)} missing at its end")
        if self.misplaced:
            parts.append(
                f"the times of {self.misplaced} chunk{'s' * (self.misplaced > 1)} are wrong"
            )
        if self.pictures:
            parts.append("its pictures for other programs are not whole")
        return f"{name} is damaged: {', '.join(parts)}." if parts else ""


def _ticks(count: int) -> str:
    return "1 tick is" if count == 1 else f"{count} ticks are"
