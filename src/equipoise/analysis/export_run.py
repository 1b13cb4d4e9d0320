"""A run in the format of another program."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

from equipoise.analysis.run_context import RunContext
from equipoise.errors import RunLogError
from equipoise.runlog import Run, export_csv, export_npz, export_parquet, load_run
from equipoise.runlog.folders import LOG_NAME


def export_run(folder: Path, kind: str, to: Path | None = None) -> tuple[Path, str]:
    """Write a run as `kind`; return the file and what is wrong with the log, "" if nothing is.

    Raises: RunLogError if the log cannot be read or the file not written; InputError if a package
    is missing.
    """
    run = load_run(folder)
    path = to if to is not None else run.folder / f"run.{kind}"
    if kind == "mcap":
        _add_pictures(run, Path(folder), path)
    elif kind == "rrd":
        from equipoise.analysis.rerun_export import export_rrd

        export_rrd(run, path)
    else:
        {"npz": export_npz, "csv": export_csv, "parquet": export_parquet}[kind](run, path)
    return path, run.note


def _add_pictures(run: Run, source: Path, path: Path) -> None:
    from equipoise.analysis.foxglove.write import add_pictures

    log = source / LOG_NAME if source.is_dir() else source
    if path.resolve() != log.resolve():
        try:
            shutil.copyfile(log, path)
        except OSError as error:
            raise RunLogError(f"Cannot write {path}: {error.strerror}.") from error
    add_pictures(RunContext.of(replace(run, folder=path.parent)), path)
