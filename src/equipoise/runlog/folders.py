"""Run folders: making them, finding the latest, and the summary in them."""

from __future__ import annotations

import json
import math
import os
import re
import tempfile
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from equipoise.errors import InputError, RunLogError

LOG_NAME = "run.mcap"
SUMMARY_NAME = "summary.json"
LATEST_NAME = "latest"
LOG_GLOB = "*/run.mcap"

_NON_FINITE = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


def new_run_folder(root: Path, scenario_name: str) -> Path:
    """Make a new folder <scenario>-<date>-<time> under `root` and note it as the latest.

    Raises: RunLogError if it cannot be made; InputError if the name holds no letter or digit.
    """
    root = Path(root)
    stem = re.sub(r"[^\w.-]+", "-", scenario_name).strip(".-_")
    if not stem:
        raise InputError("A scenario's name needs a letter or a digit", given=scenario_name)
    stem = f"{stem[:100]}-{datetime.now().astimezone():%Y%m%d-%H%M%S}"
    try:
        root.mkdir(parents=True, exist_ok=True)
        folder = _make_distinct(root, stem)
        _note_latest(root, folder)
    except OSError as error:
        raise RunLogError(f"Cannot make a run folder in {root}: {error.strerror}.") from error
    return folder


def check_place(folder: Path) -> None:
    """Refuse a folder in which no run could be written, before work begins; it is not made.

    Raises: InputError if it holds a run already, or what is in its way is no folder or forbids it.
    """
    if (folder / LOG_NAME).exists():
        raise InputError(
            "the folder already holds a run", given=str(folder), remedy="Give a new one"
        )
    above = next((place for place in (folder, *folder.absolute().parents) if place.exists()), None)
    if above is None or not above.is_dir():
        raise InputError(f"{above} is no folder", given=str(folder), remedy="Give another place")
    try:
        with tempfile.TemporaryDirectory(prefix=".equipoise-", dir=above):
            pass
    except OSError as error:
        raise InputError(
            f"nothing can be written in {above}: {(error.strerror or str(error)).lower()}",
            given=str(folder),
            remedy="Give another place",
        ) from None


def latest_run(root: Path) -> Path:
    """Return the folder of the run under `root` that was begun last.

    Raises: RunLogError if there is none.
    """
    root = Path(root)
    note = root / LATEST_NAME
    try:
        if note.is_file() and (root / note.read_text(encoding="utf-8").strip()).is_dir():
            return root / note.read_text(encoding="utf-8").strip()
        if note.is_dir():
            return note.resolve()
        logs = list(root.glob(LOG_GLOB))
        if logs:
            return max(logs, key=lambda log: log.stat().st_mtime_ns).parent
    except OSError as error:
        raise RunLogError(f"Cannot look for runs in {root}: {error.strerror}.") from error
    raise RunLogError(f"There is no run in {root}. Run a scenario first or give another folder.")


def write_summary(folder: Path, summary: Mapping[str, object]) -> None:
    """Write summary.json at once or not at all; NaN and infinities become "nan", "inf", "-inf".

    Raises: RunLogError if the disk refuses; InputError for values that JSON cannot hold.
    """
    path = Path(folder) / SUMMARY_NAME
    text = json.dumps(_to_json(summary), indent=2, allow_nan=False, ensure_ascii=False)
    partial = path.with_name(f".{SUMMARY_NAME}.{os.getpid()}")
    try:
        partial.write_text(text + "\n", encoding="utf-8")
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise RunLogError(f"Cannot write {path}: {error.strerror}.") from error


def read_summary(folder: Path) -> dict[str, Any]:
    """Read summary.json; "nan", "inf" and "-inf" become numbers again.

    Raises: RunLogError if it is missing or broken.
    """
    path = Path(folder) / SUMMARY_NAME
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RunLogError(f"Cannot read {path}: {error.strerror}.") from error
    except (ValueError, RecursionError) as error:
        raise RunLogError(f"{path} is not valid JSON: {error}.") from error
    if not isinstance(summary, dict):
        raise RunLogError(f"{path} should hold an object, not a {type(summary).__name__}.")
    return {key: _from_json(value) for key, value in summary.items()}


def _make_distinct(root: Path, stem: str) -> Path:
    count = 1
    while True:
        folder = root / (stem if count == 1 else f"{stem}-{count}")
        try:
            folder.mkdir()
        except FileExistsError:
            count += 1
        else:
            return folder


def _note_latest(root: Path, folder: Path) -> None:
    """Point `latest` to the folder, by a file where the disk knows no symbolic links."""
    latest, fresh = root / LATEST_NAME, root / f".{LATEST_NAME}-{folder.name}"
    if latest.is_dir() and not latest.is_symlink():
        return  # a folder of someone's own; leave it alone
    try:
        fresh.symlink_to(folder.name, target_is_directory=True)
    except OSError:
        fresh.write_text(folder.name + "\n", encoding="utf-8")
    fresh.replace(latest)


def _to_json(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _to_json(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_to_json(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0.0 else "-inf"
    if value is None or isinstance(value, str | bool | int | float):
        return value
    if isinstance(value, Path):
        return str(value)
    raise InputError(
        f"A summary cannot hold a {type(value).__name__}",
        given=value,
        remedy="Give numbers, texts, lists, mappings or arrays",
    )


def _from_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _from_json(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_from_json(entry) for entry in value]
    if isinstance(value, str):
        return _NON_FINITE.get(value, value)
    return value
