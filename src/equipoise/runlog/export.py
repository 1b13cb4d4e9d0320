"""Taking a run's numbers elsewhere: npz for numpy, csv for everything, parquet for tables."""

from __future__ import annotations

import csv
import zipfile
from pathlib import Path

import numpy as np

from equipoise.errors import InputError, RunLogError
from equipoise.runlog.run import Run

_ROWS_AT_ONCE = 1000


def export_npz(run: Run, path: Path) -> None:
    """Write `t` and every channel by its name, bit for bit; equal runs give equal files.

    Raises: RunLogError if the file cannot be written.
    """
    # Not np.savez: a channel named as one of its own arguments ("file") could not be saved.
    try:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for name, array in {"t": run.t, **run.arrays}.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                    np.lib.format.write_array(entry, array, allow_pickle=False)
    except OSError as error:
        raise RunLogError(f"Cannot write {path}: {error.strerror}.") from error


def export_csv(run: Run, path: Path) -> None:
    """Write one header row "name[label] (unit)" and a row a tick, each number to its last bit.

    Raises: RunLogError if the file cannot be written.
    """
    header = ["t (s)", *(title for channel in run.channels.values() for title in channel.columns)]
    columns = [run.t[:, None], *run.arrays.values()]
    try:
        with open(path, "w", newline="", encoding="utf-8") as stream:
            table = csv.writer(stream)
            table.writerow(header)
            for start in range(0, run.t.size, _ROWS_AT_ONCE):
                rows = slice(start, start + _ROWS_AT_ONCE)
                table.writerows(np.hstack([column[rows] for column in columns]).tolist())
    except OSError as error:
        raise RunLogError(f"Cannot write {path}: {error.strerror}.") from error


def export_parquet(run: Run, path: Path) -> None:
    """Write a column of doubles for `t` and each number, titled as in `export_csv`.

    The description of each channel is in the metadata of its columns.
    Raises: InputError without pyarrow; RunLogError if the file cannot be written.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise InputError(
            "parquet needs pyarrow", remedy="pip install pyarrow, or choose csv or npz"
        ) from None
    columns, fields = [pyarrow.array(run.t)], [pyarrow.field("t (s)", pyarrow.float64())]
    for name, channel in run.channels.items():
        for k, title in enumerate(channel.columns):
            columns.append(pyarrow.array(np.ascontiguousarray(run[name][:, k])))
            fields.append(
                pyarrow.field(title, pyarrow.float64(), metadata={"description": channel.doc})
            )
    table = pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields))
    try:
        parquet.write_table(table, path, compression="zstd")
    except OSError as error:
        raise RunLogError(f"Cannot write {path}: {error.strerror or error}.") from error
