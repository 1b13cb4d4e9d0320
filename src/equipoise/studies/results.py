"""The tables of a study: results that repeat bit for bit, and beside them times that do not."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from equipoise.errors import InputError, RunLogError
from equipoise.studies.folder import StudyFolder, write_whole
from equipoise.studies.journal import Result
from equipoise.studies.plan import Plan, RunId
from equipoise.studies.schema import StudySpec

RESULTS, TIMES, DESIGN = "results.parquet", "times.parquet", "design.parquet"
OF_RUN = ("design", "point", "controller", "repeat", "step", "line", "share")
OF_ROW = ("stands", "good", "cause", "why", "t_end")
TEXTS = {"design", "controller", "line", "cause", "why"}
WHOLE = {"point", "repeat", "step"}


def write_tables(folder: StudyFolder, study: StudySpec, results: Mapping[str, Result]) -> None:
    """Write results, times and points, ordered by run. Raises: `OSError`, `InputError`."""
    ordered = [results[str(run_id)] for run_id in sorted(map(RunId.read, results))]
    metrics = sorted({name for one in ordered for name in one["row"]["metrics"]})
    rows = [_flat(one, study, metrics) for one in ordered]
    write_table(folder.path / RESULTS, rows)
    names = sorted({name for one in ordered for name in one["times"]})
    times = [
        {"run": one["id"], **{name: one["times"].get(name) for name in names}} for one in ordered
    ]
    write_table(folder.path / TIMES, times)


def write_design(folder: StudyFolder, study: StudySpec) -> None:
    """Write the points that are known before anything runs: where lines begin, for boundaries."""
    rows = []
    for run in Plan(study).first():
        if run.id.contender == 0 and run.id.repeat == 0:
            rows.append(
                {"design": run.id.design, "point": run.id.point, "line": run.line}
                | {name: run.values.get(name) for name in study.parameters}
            )
    write_table(folder.path / DESIGN, rows)


def _flat(one: Result, study: StudySpec, metrics: Sequence[str]) -> dict[str, Any]:
    row, run_id = one["row"], RunId.read(one["id"])
    flat = {name: getattr(run_id, name, row.get(name)) for name in OF_RUN}
    flat["controller"] = row["controller"]
    flat |= {name: row[name] for name in OF_ROW}
    flat |= {f"p.{name}": row["values"].get(name) for name in study.parameters}
    flat |= {f"m.{name}": row["metrics"].get(name) for name in metrics}
    return flat


def write_table(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows with the same keys as Parquet, at once or not at all; the same rows, same bytes.

    Raises: `OSError`; `InputError` without pyarrow.
    """
    arrow = _arrow()
    columns = {}
    for name in rows[0] if rows else ():
        values = [row[name] for row in rows]
        columns[name] = arrow.array(*_typed(arrow, name, values))
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(arrow.table(columns), stream, compression="zstd")
    write_whole(path, stream.getvalue())


def _typed(arrow: Any, name: str, values: list[Any]) -> tuple[list[Any], Any]:
    if name in WHOLE:
        return values, arrow.int64()
    if name in TEXTS or any(isinstance(value, str | list | dict) for value in values):
        return [None if value is None else str(value) for value in values], arrow.string()
    if all(isinstance(value, bool) for value in values):
        return values, arrow.bool_()
    return [None if value is None else float(value) for value in values], arrow.float64()


def read_table(path: Path) -> dict[str, np.ndarray]:
    """Return the columns of a Parquet file; missing values are NaN or "". Raises: `RunLogError`."""
    _arrow()
    from pyarrow import ArrowException, parquet

    try:
        table = parquet.read_table(path)
    except (OSError, ArrowException) as error:
        raise RunLogError(f"Cannot read {path}: {error}.") from error
    columns = {}
    for name in table.column_names:
        values = table.column(name).to_pylist()
        if name in TEXTS or any(isinstance(value, str) for value in values):
            columns[name] = np.array(["" if v is None else str(v) for v in values], dtype=object)
        else:
            columns[name] = np.array([np.nan if v is None else v for v in values])
    return columns


@dataclass(frozen=True, eq=False)
class Results:
    """What a study found: a column (n,) each; `study` says what they mean."""

    study: StudySpec
    columns: Mapping[str, np.ndarray]
    times: Mapping[str, np.ndarray]
    folder: Path

    def __len__(self) -> int:
        return len(self.columns["point"])

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    @cached_property
    def controllers(self) -> list[str]:
        """The controllers, as the study names them."""
        return [name for name in self.study.controllers if (self["controller"] == name).any()]

    def where(self, **wanted: Any) -> np.ndarray:
        """Return which rows (n,) have these values in these columns."""
        mask = np.ones(len(self), dtype=bool)
        for name, value in wanted.items():
            mask &= self.columns[name] == value
        return mask

    def designs(self, kinds: Iterable[str]) -> list[str]:
        """Return the names of the designs of some kinds."""
        wanted = set(kinds)
        return [name for name, spec in self.study.designs.items() if spec.kind in wanted]


def load_results(path: Path | str) -> Results:
    """Return the results in a study's folder. Raises: `RunLogError` if there are none."""
    folder = StudyFolder(path)
    study = folder.spec()
    columns = read_table(folder.path / RESULTS)
    if not columns:
        raise RunLogError(f"{folder.path} holds no result yet.")
    return Results(study, columns, read_table(folder.path / TIMES), folder.path)


def _arrow() -> Any:
    try:
        import pyarrow
    except ImportError:
        raise InputError("a study needs pyarrow", remedy="pip install 'equipoise[study]'") from None
    return pyarrow
