"""Ratios between ours and others in the same run, and whether they got worse than kept ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from equipoise.bench.rows import Row
from equipoise.errors import InputError

WORSE = 4.0 / 3.0  # a ratio may grow by a third


@dataclass(frozen=True)
class Ratio:
    """Median of ours over the median of another in the same run."""

    ours: str
    other: str
    value: float


@dataclass(frozen=True)
class Change:
    """The same ratio as it was kept and as it is now."""

    kept: Ratio
    now: Ratio

    @property
    def passed(self) -> bool:
        """Whether it is not worse by more than a third."""
        return self.now.value <= WORSE * self.kept.value

    def __str__(self) -> str:
        word = "holds" if self.passed else "is worse by more than a third"
        return (
            f"{self.now.ours} / {self.now.other} {word}: "
            f"{self.now.value:.3f}, kept {self.kept.value:.3f}"
        )


def ratios(rows: Sequence[Row]) -> list[Ratio]:
    """Return every ratio that means something, of a robot to the same robot.

    The whole tick stands over each peer; hierarchies over DAQP on the same rows; parts of the tick
    and the engine over DAQP too, which then only measures the machine.
    """
    medians = {row.name: row.median_us for row in rows}
    found = []
    for name in medians:
        group, *rest = name.split("/")
        if group in ("tick", "hqp", "rigid") and len(rest) == 2:
            found += [Ratio(name, o, medians[name] / medians[o]) for o in _others(name, medians)]
    return found


def _others(name: str, medians: Mapping[str, float]) -> list[str]:
    group, robot, case = name.split("/")
    others = [f"daqp/{robot}/{case if group == 'hqp' else 'tray'}"]
    if group == "tick" and case == "tray":
        others += [o for o in medians if o.startswith("peer/") and o.split("/")[2] == robot]
    return [other for other in others if other in medians]


def compare(rows: Sequence[Row], kept: Sequence[Row]) -> list[Change]:
    """Return the change of every ratio that both have. Absolute times are never compared.

    Raises: `InputError` if there is none.
    """
    now = {(r.ours, r.other): r for r in ratios(rows)}
    changes = [
        Change(before, now[before.ours, before.other])
        for before in ratios(kept)
        if (before.ours, before.other) in now
    ]
    if not changes:
        raise InputError(
            "the kept results have no ratio in common with this run",
            given=[row.name for row in kept][:10],
            remedy="Compare runs with the same robots and peers",
        )
    return changes
