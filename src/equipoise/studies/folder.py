"""The folder of a study: which study it is, its points, where its results come from, who works."""

from __future__ import annotations

import fcntl
import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any
from uuid import uuid4

from equipoise.errors import InputError, RunLogError
from equipoise.studies.provenance import provenance, source_hash
from equipoise.studies.schema import StudySpec

STUDY, PROVENANCE, EVENTS = "study.json", "provenance.json", "events.jsonl"
ROWS, FAILED = "rows", "failed"
TOKEN, CLIENT_LOCK, WORK_LOCK = ".token", ".client.lock", ".work.lock"
SOON = 0.2  # [s] between two looks at a lock


def study_text(study: StudySpec) -> str:
    """Return what makes a study this one and no other: all but where it runs and what is logged."""
    content = study.model_dump(mode="json", exclude={"engine", "logs"}, exclude_none=True)
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


class StudyFolder:
    """A folder that belongs to one study, made with one source."""

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.rows = self.path / ROWS

    def open(self, study: StudySpec) -> None:
        """Make the folder, or see that it holds this study. Raises: `InputError`, `RunLogError`."""
        try:
            self.rows.mkdir(parents=True, exist_ok=True)
            text, kept = study_text(study), self.path / STUDY
            if not kept.exists():
                write_whole(self.path / TOKEN, uuid4().hex)
                write_json(self.path / PROVENANCE, provenance())
                write_whole(kept, text)  # last: where it is, all is there
                return
            if kept.read_text(encoding="utf-8") != text:
                raise InputError(
                    "the folder holds another study",
                    given=str(self.path),
                    remedy="Give a new folder with --out, or delete this one",
                )
            told = json.loads((self.path / PROVENANCE).read_text(encoding="utf-8"))
        except OSError as error:
            raise RunLogError(f"Cannot use {self.path}: {error.strerror}.") from error
        if told.get("source") != source_hash():
            raise InputError(
                "this study was begun with other code: its results would not belong together",
                given=str(self.path),
                remedy="Give a new folder with --out, or go on with the code it was begun with",
            )

    @property
    def token(self) -> str:
        """What tells this folder from another of the same name on another machine."""
        return (self.path / TOKEN).read_text(encoding="utf-8")

    def has(self, token: str) -> bool:
        """Say whether the folder with this token is to be seen from here."""
        try:
            return self.token == token
        except OSError:
            return False

    def spec(self) -> StudySpec:
        """Return the study that the folder holds. Raises: `RunLogError` if it holds none."""
        try:
            return StudySpec.model_validate_json((self.path / STUDY).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise RunLogError(f"{self.path} holds no study that can be read.") from error

    def tell(self, event: str, **more: Any) -> None:
        """Append an event with its time to events.jsonl."""
        line = json.dumps({"time": round(time.time(), 3), "event": event, **more})
        with open(self.path / EVENTS, "a", encoding="utf-8") as stream:
            stream.write(line + "\n")

    @contextmanager
    def as_only_client(self, waiting: Callable[[], None]) -> Iterator[None]:
        """Be the one that gives out this study's runs, once nobody works on runs given before.

        `waiting` is told if workers of a client that is gone still work.
        Raises: `InputError` if another client lives.
        """
        with open(self.path / CLIENT_LOCK, "a", encoding="utf-8") as mine:
            if not _locked(mine, fcntl.LOCK_EX):
                raise InputError(
                    "this study is running already, in another process", given=str(self.path)
                )
            with open(self.path / WORK_LOCK, "a", encoding="utf-8") as work:
                told = False
                while not _locked(work, fcntl.LOCK_EX):
                    if not told:
                        waiting()
                    told = True
                    time.sleep(SOON)
            yield

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Be one of those that work on runs; it ends with the process at the latest."""
        with open(self.path / WORK_LOCK, "a", encoding="utf-8") as stream:
            fcntl.flock(stream, fcntl.LOCK_SH)
            yield


def _locked(stream: IO[str], kind: int) -> bool:
    try:
        fcntl.flock(stream, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def write_whole(path: Path, text: str | bytes) -> None:
    """Write a file at once or not at all. Raises: `OSError`."""
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        partial.write_bytes(text.encode() if isinstance(text, str) else text)
        partial.replace(path)
    except OSError:
        partial.unlink(missing_ok=True)
        raise


def write_json(path: Path, content: Any) -> None:
    """Write JSON at once or not at all. Raises: `OSError`."""
    write_whole(path, json.dumps(content, indent=1, ensure_ascii=False) + "\n")
