"""The exceptions of Equipoise, one tree.

EquipoiseError
├── InputError             a person can fix it: says what was given, what exists, what to do
│   ├── NameNotFoundError  a name (frame, joint, task, robot, ...) that does not exist
│   ├── ShapeError         an array of the wrong shape
│   ├── NonFiniteError     a NaN or an infinity where a number was wanted
│   ├── RobotFileError     a robot description that cannot be trusted
│   └── ScenarioError      a scenario file with a wrong key or value
└── RunLogError            a run folder or log that cannot be written or read

A numerical outcome inside the control loop is never an exception but a status (see `hqp.Solution`).
"""

from __future__ import annotations

import reprlib
from collections.abc import Iterable
from difflib import get_close_matches

LISTED_AT_MOST = 40
QUOTED_AT_MOST = 160  # characters of what was given: a line

_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother, _SHORT.maxlong = 4, 120, 120, 60
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = _SHORT.maxset = _SHORT.maxarray = 16


def quoted(value: object) -> str:
    """Return what was given as Python writes it, a line at most; the middle of more is left out."""
    text = repr(value) if isinstance(value, str) and len(value) <= 120 else _SHORT.repr(value)
    text = " ".join(text.split())
    if len(text) > QUOTED_AT_MOST:
        text = f"{text[: QUOTED_AT_MOST - 40]} ... {text[-30:]}"
    return text


def one_line(said: object) -> str:
    """Return what a library said on one line of a length that can be read."""
    line = " ".join(str(said).split())
    return line if len(line) <= 2 * QUOTED_AT_MOST else f"{line[:QUOTED_AT_MOST]} ... {line[-120:]}"


class EquipoiseError(Exception):
    """Base of every error that Equipoise raises on purpose."""


class InputError(EquipoiseError):
    """An input that a person can correct.

    Attributes: `problem` (what is wrong), `given` (what was given), `known` (what exists),
    `remedy` (what to do). The message is put together from them.
    """

    def __init__(
        self,
        problem: str,
        *,
        given: object = None,
        known: Iterable[str] = (),
        remedy: str = "",
    ) -> None:
        self.problem = problem
        self.given = given
        self.known = tuple(known)
        self.remedy = remedy
        super().__init__(self._compose())

    def _compose(self) -> str:
        parts = [self.problem.rstrip(".") + "."]
        if self.given is not None:
            parts.append(f"Given: {quoted(self.given)}.")
        if self.known:
            parts.append(f"Known: {', '.join(self.known)}.")
        if self.remedy:
            parts.append(self.remedy if self.remedy[-1] in ".?!" else f"{self.remedy}.")
        return " ".join(parts)


def _nearest(name: str, names: list[str], count: int, cutoff: float) -> list[str]:
    """Return the names most like `name`, the likest first; capitals do not count."""
    by_small: dict[str, list[str]] = {}
    for known in names:
        by_small.setdefault(known.lower(), []).append(known)
    small = get_close_matches(name.lower()[:QUOTED_AT_MOST], by_small, n=count, cutoff=cutoff)
    return [known for key in small for known in by_small[key]][:count]


class NameNotFoundError(InputError):
    """A name that does not exist; the message offers the nearest ones that do."""

    def __init__(self, kind: str, name: object, known: Iterable[str], *, remedy: str = "") -> None:
        names, name = sorted(known), name if isinstance(name, str) else repr(name)
        near = _nearest(name, names, 3, 0.6)
        hint = f"Did you mean {' or '.join(quoted(n) for n in near)}?" if near else ""
        if len(names) > LISTED_AT_MOST:
            likest = _nearest(name, names, LISTED_AT_MOST // 2, 0.0)
            names = [*likest, f"and {len(names) - len(likest)} more"]
        super().__init__(
            f"There is no {kind} {quoted(name)}",
            known=names,
            remedy=" ".join(part for part in (hint, remedy) if part),
        )
        self.kind = kind
        self.name = name


class ShapeError(InputError):
    """An array whose shape is not the wanted one."""

    def __init__(self, name: str, given: tuple[int, ...], wanted: tuple[int | str, ...]) -> None:
        super().__init__(f"{name} has shape {given}, wanted {wanted}")
        self.name = name


class NonFiniteError(InputError):
    """A NaN or an infinity where a finite number is needed."""


class RobotFileError(InputError):
    """A robot description that cannot be trusted; names the link or joint and the remedy."""


class ScenarioError(InputError):
    """A scenario with a wrong key or value; `path` says where, `line` the line if known."""

    def __init__(
        self,
        problem: str,
        *,
        path: str = "",
        line: int | None = None,
        given: object = None,
        known: Iterable[str] = (),
        remedy: str = "",
    ) -> None:
        self.path = path
        self.line = line
        self.plain = problem
        where = f"line {line}, " if line is not None else ""
        path = path if len(path) <= QUOTED_AT_MOST else f"{path[:80]} ... {path[-40:]}"
        prefix = f"{where}{path}: " if path else where
        super().__init__(prefix + problem, given=given, known=known, remedy=remedy)

    def at(self, place: str, *, line: int | None = None) -> ScenarioError:
        """Return the same complaint that begins with its place: a file (and line), an option."""
        said = ScenarioError(
            self.plain, path=self.path, line=line, given=self.given, known=self.known,
            remedy=self.remedy,
        )  # fmt: skip
        said.problem = f"{place}: {said.problem}"
        said.args = (said._compose(),)
        return said


class AdviceWarning(UserWarning):
    """What was asked for can be run, but had better be otherwise; the message says why and how."""


class RunLogError(EquipoiseError):
    """A run folder or a log that cannot be written or read."""
