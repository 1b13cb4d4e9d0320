"""Rows of a bench: what was timed, its median and tail, and the file they are kept in."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from equipoise.errors import InputError

NEEDED = ("name", "median_us", "p99_us")


@dataclass(frozen=True)
class Row:
    """One thing that was timed over `ticks` ticks.

    `median_us`, `p99_us` [us]; `failures` counts ticks without a usable answer; `remark` says
    what stands behind the name (a version, a size).
    """

    name: str
    median_us: float
    p99_us: float
    ticks: int = 0
    failures: int = 0
    remark: str = ""


def write_rows(path: Path, rows: Sequence[Row]) -> None:
    """Write rows as a JSON list. Raises: `InputError` if the file cannot be written."""
    text = json.dumps([asdict(row) for row in rows], indent=1)
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write the results: {error}", given=str(path)) from None


def require_place(path: Path) -> None:
    """Refuse a file that could not be written later, without touching it. Raises: `InputError`."""
    if path.is_dir() or not path.absolute().parent.is_dir():
        raise InputError(
            "cannot write the results there",
            given=str(path),
            remedy="Name a file in a folder that exists",
        )


def read_rows(path: Path) -> list[Row]:
    """Read rows that `write_rows` wrote.

    Raises: `InputError` if the file is missing or holds something else.
    """
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise InputError(
            f"cannot read the results: {error}",
            given=str(path),
            remedy="Name a file that `equipoise bench --json FILE` wrote",
        ) from None
    if not isinstance(found, list):
        raise _not_rows(path, "a list of rows was wanted")
    return [_row(path, one) for one in found]


def _row(path: Path, one: Any) -> Row:
    if not isinstance(one, dict) or not all(key in one for key in NEEDED):
        raise _not_rows(path, f"each row needs {', '.join(NEEDED)}")
    known = {field.name for field in fields(Row)}
    row = Row(**{key: value for key, value in one.items() if key in known})
    for value in (row.median_us, row.p99_us):
        if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0.0:
            raise _not_rows(path, f"row {row.name!r} has no positive times")
    return row


def _not_rows(path: Path, why: str) -> InputError:
    return InputError(
        f"the file holds no results of the bench: {why}",
        given=str(path),
        remedy="Write one with: equipoise bench --json FILE",
    )
