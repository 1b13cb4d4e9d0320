"""Logs of runs: written while a run runs, safe against its death, read back as arrays."""

from __future__ import annotations

from equipoise.runlog.channels import Channel
from equipoise.runlog.export import export_csv, export_npz, export_parquet
from equipoise.runlog.folders import latest_run, new_run_folder, read_summary, write_summary
from equipoise.runlog.reader import CHECKED_WHOLE, check_log, load_run
from equipoise.runlog.record import TickRecord
from equipoise.runlog.run import Run
from equipoise.runlog.writer import RunWriter

__all__ = [
    "CHECKED_WHOLE",
    "Channel",
    "Run",
    "RunWriter",
    "TickRecord",
    "check_log",
    "export_csv",
    "export_npz",
    "export_parquet",
    "latest_run",
    "load_run",
    "new_run_folder",
    "read_summary",
    "write_summary",
]
