"""An explanation in numbers and in words: what is short, and what blocks it by how much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.hqp.row_names import RowDescription, as_error, quantity

SHOWN = 4  # blockers that a sentence names
LINES = 8  # lines of details of one task
COMPONENTS = 3  # rows in such a line
NEGLIGIBLE = 1e-3  # share of a shortfall that is not worth a word
WORTH_NAMING = 5e-3  # share above which a blocker is named, if any is above it: no "0%"


MET, AT_BOUND, LEFT_OVER, SHORT = "met", "at its bound", "left over", "short"  # how a task stands
Rows = Sequence[tuple[RowDescription, float]]


def amounts_of(rows: Rows) -> tuple[tuple[float, str], ...]:
    """Return how far rows with these violations are short, by unit: as an error, by their rates.

    Components of one quantity (a position) are put together; of rows that are called
    differently (several distances) it is the worst.
    """
    squares: dict[str, float] = {}
    worst = worst_of(rows)
    for words, w in rows:
        if w and worst in ("", words.phrase(w)):
            value, unit = as_error(w / words.weight, words.unit, words.rate(w))
            squares[unit] = squares.get(unit, 0.0) + value * value
    amounts = [(square**0.5, unit) for unit, square in squares.items()]
    most = max((value for value, _ in amounts), default=0.0)
    return tuple(a for a in amounts if a[0] > NEGLIGIBLE * most)


def worst_of(rows: Rows) -> str:
    """Return how the worst row is called, if rows that are short are called differently."""
    short = sorted(((abs(w), words.phrase(w)) for words, w in rows if w), reverse=True)
    return short[0][1] if len({phrase for _, phrase in short}) > 1 else ""


@dataclass(frozen=True, slots=True)
class Blocker:
    """A row that keeps a task short.

    `row`, `name`, `level` in the hierarchy; `multiplier` of the row on the task's level, zero if it
    only comes into the way once others have given way; `share` of the shortfall [0..1] that its
    giving way would remove; `broken`, how far A v has to go beyond the row's bound (signed, in its
    unit) if the task is to be met; `short`, how far it is beyond it already.
    """

    row: int
    name: str
    level: int
    words: RowDescription
    multiplier: float
    share: float
    broken: float
    short: float

    @property
    def phrase(self) -> str:
        """How a person calls the bound that blocks."""
        return self.words.phrase(self.broken or self.multiplier)

    @property
    def task(self) -> str:
        """The name of the task that the row belongs to."""
        return self.name.split("/", 1)[0]

    @property
    def gives(self) -> str:
        """How far the bound would have to be moved, as a speed and as the error it stands for."""
        speed, unit = abs(self.broken) / self.words.weight, self.words.unit
        error, of_error = as_error(speed, unit, self.words.rate(self.broken))
        text = quantity(speed, unit)
        return text if of_error == unit else f"{text} ({quantity(error, of_error)})"


@dataclass(frozen=True, slots=True)
class Shortfall:
    """A task that is short: its rows with their violation, and what blocks it, the worst first.

    `behind`: rows of the hierarchy that hold blockers where they are, if these are violated
    themselves. `alone` is what stays violated even if the task comes first: its rows contradict
    each other, or no motion of the robot moves them. `standing`: SHORT if the task failed its user,
    LEFT_OVER or AT_BOUND if it did not.
    """

    task: str
    level: int
    rows: tuple[tuple[RowDescription, float], ...]
    blockers: tuple[Blocker, ...]
    behind: tuple[int, ...]
    alone: float
    standing: str = SHORT

    @property
    def size(self) -> float:
        """The Euclidean norm of the violation, in the units of the rows."""
        return float(np.linalg.norm([w for _, w in self.rows]))

    @property
    def breaking(self) -> tuple[Blocker, ...]:
        """The rows whose bounds would have to be moved for the task to be met."""
        return tuple(b for b in self.blockers if b.broken)

    @property
    def amounts(self) -> tuple[tuple[float, str], ...]:
        """How far the task is short, by unit (see `amounts_of`)."""
        return amounts_of(self.rows)

    @property
    def worst(self) -> str:
        """How the worst row is called, if rows that are short are called differently."""
        return worst_of(self.rows)

    @property
    def shares(self) -> tuple[tuple[str, float], ...]:
        """What blocks, by name, with its part of the shortfall; the worst first."""
        shares: dict[str, float] = {}
        for blocker in self.breaking:
            shares[blocker.phrase] = shares.get(blocker.phrase, 0.0) + blocker.share
        return tuple(sorted(shares.items(), key=lambda shared: -shared[1]))

    def __str__(self) -> str:
        sizes = " and ".join(quantity(*amount) for amount in self.amounts)
        worst = f" ({self.worst})" if self.worst else ""
        if self.standing == LEFT_OVER:
            return f"{self.task} is left over, {sizes} from what it would be{worst}."
        if self.standing == AT_BOUND:
            return f"{self.task} is at its bound, {sizes} beyond it{worst}."
        return f"{self.task} is {sizes} short{worst}{self._why()}."

    def details(self) -> str:
        """Return a line for each bound that would have to move, the worst blockers first."""
        groups: dict[str, list[Blocker]] = {phrase: [] for phrase, _ in self.shares}
        for blocker in self.breaking:
            groups[blocker.phrase].append(blocker)
        lines = [_detail(phrase, group) for phrase, group in groups.items()]
        more = len(lines) - LINES
        return "\n".join(lines if more <= 0 else [*lines[:LINES], f"  and {more} more"])

    def _why(self) -> str:
        named = [self._share(*shared) for shared in self._shares_worth_naming()]
        reasons = []
        if named:
            more = len(named) - SHOWN
            named = [*named[:SHOWN], f"{more} more"] if more > 0 else named
            reasons.append("blocked " + _joined([f"by {name}" for name in named]))
        elif self.breaking:
            nearest = list(dict.fromkeys(b.phrase for b in self.breaking))[:SHOWN]
            reasons.append("blocked " + _joined([f"by {name}" for name in nearest]))
        breaking = {b.task for b in self.breaking}
        held = sorted({b.task for b in self.blockers} - breaking)
        if held and reasons:
            reasons.append("while " + _joined(held) + (" hold" if len(held) > 1 else " holds"))
        if self.alone:
            part = f"{self.alone / self.size:.0%} of it" if self.size else "some of it"
            reasons.append(f"no motion of the robot, whatever gives way, would meet {part}")
        return ": " + ", ".join(reasons) if reasons else ""

    def _shares_worth_naming(self) -> list[tuple[str, float]]:
        large = [shared for shared in self.shares if shared[1] > WORTH_NAMING]
        return large or [shared for shared in self.shares if shared[1] > NEGLIGIBLE]

    def _share(self, phrase: str, share: float) -> str:
        if len(self.amounts) == 1 and not self.worst:
            value, unit = self.amounts[0]
            return f"{phrase} ({quantity(share * value, unit)})"
        return f"{phrase} ({share:.{0 if share > WORTH_NAMING else 1}%})"


@dataclass(frozen=True, slots=True)
class Explanation:
    """What is short and why, in the order of the hierarchy; it prints as sentences.

    `optimal`: whether the certificate of the answer holds. If not, part of what is short is owed to
    the solver and not to the rows that are named.
    """

    shortfalls: tuple[Shortfall, ...]
    optimal: bool = True
    asked: tuple[str, ...] = ()

    def of(self, task: str) -> Shortfall | None:
        """Return what is said of a task, None if it is met."""
        return next((s for s in self.shortfalls if s.task == task), None)

    def __str__(self) -> str:
        return self._listed([str(s) for s in self.shortfalls])

    def details(self) -> str:
        """Return the sentences with a line for every bound that would have to move."""
        return self._listed([f"{s}\n{s.details()}".rstrip() for s in self.shortfalls])

    def _listed(self, parts: list[str]) -> str:
        if not self.optimal:
            parts = ["This answer is not the optimum; a better one may meet more.", *parts]
        if self.shortfalls and not any(s.standing == SHORT for s in self.shortfalls):
            parts = ["No task is short.", *parts] if not self.asked else parts
        met = [f"{task} is met." for task in self.asked if self.of(task) is None]
        return "\n".join([*parts, *met]) or "Every task is met."


def _detail(phrase: str, group: list[Blocker]) -> str:
    """Return a line about the rows that are called the same, the largest steps first."""
    group = sorted(group, key=lambda b: -abs(b.broken))
    most: dict[str, float] = {}
    for b in group:
        most[b.words.unit] = max(most.get(b.words.unit, 0.0), abs(b.broken))
    group = [b for b in group if abs(b.broken) >= NEGLIGIBLE * most[b.words.unit]]
    labels = [_label(b) if len(group) > 1 else "" for b in group]
    parts = dict.fromkeys(_step(b, label) for b, label in zip(group, labels, strict=True))
    rest = "; ..." if len(parts) > COMPONENTS else ""
    listed = "; ".join([*parts][:COMPONENTS])
    return f"  level {group[0].level}  {phrase}: would have to give {listed}{rest}"


def _label(blocker: Blocker) -> str:
    label = blocker.name.rsplit("/", 1)[-1]
    return "" if label.split(" (")[0] in blocker.phrase else f"{label} "


def _step(blocker: Blocker, label: str) -> str:
    given = quantity(abs(blocker.short) / blocker.words.weight, blocker.words.unit)
    known = abs(blocker.short) > NEGLIGIBLE * abs(blocker.broken)
    return f"{label}{blocker.gives}" + (f", {given} of it already" if known else "")


def _joined(parts: list[str]) -> str:
    if len(parts) < 2:
        return "".join(parts)
    return ", ".join(parts[:-1]) + " and " + parts[-1]
