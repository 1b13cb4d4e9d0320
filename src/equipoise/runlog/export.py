"""Taking a run's numbers elsewhere: npz for numpy, csv for everything."""

from __future__ import annotations

import csv
import zipfile
from pathlib import Path

import numpy as np

from equipoise.errors import RunLogError
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
