"""What a check of a robot description found: one sentence each, errors or warnings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from equipoise.errors import RobotFileError

ERROR: Literal["error"] = "error"
WARNING: Literal["warning"] = "warning"
SHOWN_AT_ONCE = 10


@dataclass(frozen=True)
class Finding:
    """Say what is wrong where, what was given, and what to do."""

    severity: Literal["error", "warning"]
    place: str
    problem: str
    remedy: str = ""
    given: str | None = None
    line: int | None = None

    def __str__(self) -> str:
        where = f"line {self.line}, {self.place}" if self.line is not None else self.place
        given = "" if self.given is None else f" Given: {self.given!r}."
        remedy = f" {_ended(self.remedy)}" if self.remedy else ""
        return f"{where}: {_ended(self.problem)}{given}{remedy}"


def _ended(sentence: str) -> str:
    return sentence if sentence[-1] in ".?!" else f"{sentence}."


def raise_errors(path: Path, findings: Iterable[Finding]) -> None:
    """Raise the first errors among the findings together; do nothing if there is none.

    Raises: RobotFileError.
    """
    errors = [finding for finding in findings if finding.severity == ERROR]
    if not errors:
        return
    shown = "\n  ".join(str(finding) for finding in errors[:SHOWN_AT_ONCE])
    more = len(errors) - SHOWN_AT_ONCE
    tail = f"\n  ... and {more} more" if more > 0 else ""
    plural = "error" if len(errors) == 1 else "errors"
    raise RobotFileError(f"{path} has {len(errors)} {plural}:\n  {shown}{tail}")
