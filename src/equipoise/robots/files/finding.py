"""What a check of a robot description found: one sentence each, errors or warnings."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from equipoise.errors import RobotFileError, quoted

ERROR: Literal["error"] = "error"
WARNING: Literal["warning"] = "warning"
SHOWN_AT_ONCE = 10
LOG = logging.getLogger("equipoise.robots")


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
        given = "" if self.given is None else f" Given: {quoted(self.given)}."
        remedy = f" {_ended(self.remedy)}" if self.remedy else ""
        return f"{where}: {_ended(self.problem)}{given}{remedy}"


def _ended(sentence: str) -> str:
    return sentence if sentence[-1] in ".?!" else f"{sentence}."


def tell_warnings(path: Path, findings: Iterable[Finding]) -> None:
    """Say the warnings among the findings together, by the log `equipoise.robots`.

    Python shows it on the error stream unless a program says otherwise.
    """
    warnings = [finding for finding in findings if finding.severity == WARNING]
    if warnings:
        plural = "warning" if len(warnings) == 1 else "warnings"
        LOG.warning("%s has %d %s:\n  %s", path, len(warnings), plural, _shown(warnings))


def _shown(findings: list[Finding]) -> str:
    """Return the first findings, one a line, and how many more there are."""
    more = len(findings) - SHOWN_AT_ONCE
    lines = [str(finding) for finding in findings[:SHOWN_AT_ONCE]]
    return "\n  ".join([*lines, *([f"... and {more} more"] if more > 0 else [])])


def raise_errors(path: Path, findings: Iterable[Finding]) -> None:
    """Raise the first errors among the findings together; do nothing if there is none.

    Raises: RobotFileError.
    """
    errors = [finding for finding in findings if finding.severity == ERROR]
    if not errors:
        return
    plural = "error" if len(errors) == 1 else "errors"
    raise RobotFileError(f"{path} has {len(errors)} {plural}:\n  {_shown(errors)}")
