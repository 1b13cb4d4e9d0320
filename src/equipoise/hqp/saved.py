"""A hierarchy in a file: written with its words, read back without trust, to be solved again."""

from __future__ import annotations

import json
import math
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from equipoise.errors import InputError
from equipoise.hqp.hierarchy import Hierarchy
from equipoise.hqp.row_names import RowDescription, plain_descriptions
from equipoise.hqp.rows import Rows

FILE_FORMAT = 2
BYTES_MAX = 1 << 30  # of all arrays, unpacked
_REMEDY = "Give a file that `save_problem` or `equipoise explain --save` wrote"
_DAMAGED = (
    KeyError, IndexError, ValueError, TypeError, OverflowError, AttributeError, EOFError,
    RecursionError, NotImplementedError, RuntimeError, MemoryError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class SavedProblem:
    """A hierarchy with what was known about it: `words` [m], where it comes from."""

    hierarchy: Hierarchy
    words: tuple[RowDescription, ...]
    note: str = ""


def save_problem(
    path: str | Path,
    hierarchy: Hierarchy,
    *,
    words: Sequence[RowDescription] | None = None,
    note: str = "",
) -> None:
    """Write a hierarchy to an npz file: three arrays and a JSON text, no pickled objects.

    Raises: InputError if the file cannot be written.
    """
    blocks = [[b.name, b.unit, b.labels, b.level] for b in hierarchy.blocks]
    about: dict[str, Any] = {"format": FILE_FORMAT, "levels": len(hierarchy.ends), "blocks": blocks}
    about["note"] = note
    if words is not None:
        about["words"] = [
            [w.unit, w.above, w.below, _number(w.rate_above), _number(w.rate_below)]
            + ([w.weight] if w.weight != 1.0 else [])
            for w in words
        ]
    A, lower, upper = hierarchy.A, hierarchy.lower, hierarchy.upper
    try:
        with Path(path).open("wb") as file:
            np.savez(file, about=np.array(json.dumps(about)), A=A, lower=lower, upper=upper)
    except OSError as error:
        raise InputError(
            "The hierarchy cannot be written", given=str(path), remedy=f"{error.strerror}"
        ) from error


def load_problem(path: str | Path) -> SavedProblem:
    """Read what `save_problem` wrote, and check every part of it.

    Raises: InputError saying what is wrong: no such file, another file, a damaged one.
    """
    try:
        arrays, about = _unpack(Path(path))
        return _assemble(arrays, about)
    except OSError as error:
        raise InputError(
            "The file cannot be read", given=str(path), remedy=error.strerror or _REMEDY
        ) from error
    except InputError as error:
        raise InputError(
            f"The file holds no sound hierarchy: {error.problem}", given=str(path), remedy=_REMEDY
        ) from error
    except _DAMAGED as error:
        raise InputError(
            "The file holds no hierarchy, or is damaged", given=str(path), remedy=_REMEDY
        ) from error


def _unpack(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    with zipfile.ZipFile(path) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
        if size > BYTES_MAX:
            raise InputError(f"it unpacks to {size} bytes, more than {BYTES_MAX}")
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in ("A", "lower", "upper")}
        return arrays, json.loads(str(file["about"]))


def _assemble(arrays: dict[str, np.ndarray], about: dict[str, Any]) -> SavedProblem:
    if about["format"] != FILE_FORMAT:
        raise InputError(f"its format is {about['format']!r}, this version reads {FILE_FORMAT}")
    A, lower, upper = (arrays[name].astype(float, casting="safe") for name in arrays)
    levels: list[list[Rows]] = [[] for _ in range(_count(about["levels"]))]
    start, last = 0, 0
    for name, unit, labels, level in about["blocks"]:
        if not last <= level < len(levels):
            raise InputError(f"its block {name!r} is out of order")
        last, rows = level, slice(start, start + len(labels))
        levels[level].append(
            Rows(str(name), str(unit), tuple(map(str, labels)), A[rows], lower[rows], upper[rows])
        )
        start = rows.stop
    if A.ndim != 2 or not start == len(A) == len(lower) == len(upper):
        raise InputError(f"its blocks name {start} rows, its arrays hold {len(A)}")
    hierarchy = Hierarchy.stack(levels, A.shape[1])
    return SavedProblem(hierarchy, _words(about.get("words"), hierarchy), str(about["note"]))


def _words(listed: list[Any] | None, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
    if listed is None:
        return plain_descriptions(hierarchy)
    if len(listed) != len(hierarchy.lower):
        raise InputError(f"it has words for {len(listed)} rows of {len(hierarchy.lower)}")
    return tuple(
        RowDescription(
            str(unit), str(above), str(below), _rate(up), _rate(down), *map(_weight, weight)
        )
        for unit, above, below, up, down, *weight in listed
    )


def _count(levels: Any) -> int:
    if not isinstance(levels, int) or not 0 <= levels <= 10_000:
        raise InputError(f"its number of levels is {levels!r}")
    return levels


def _number(rate: float) -> float | None:
    return rate if math.isfinite(rate) else None


def _weight(weight: Any) -> float:
    if not 0.0 < float(weight) < math.inf:
        raise InputError(f"the weight of a row is {weight!r}")
    return float(weight)


def _rate(rate: Any) -> float:
    return math.nan if rate is None else float(rate)
