"""What was begun and what is done, line by line: a kill loses at most the run that it interrupts.

Every process appends to a file of its own, so none waits for another and a torn line can only be
the last one of a process that is gone.
"""

from __future__ import annotations

import json
import os
import socket
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import uuid4

Result = dict[str, Any]  # `id`, `row` (what repeats bit for bit) and `times` (what does not)


class Journal:
    """The file of this process in a folder; it is made when the first line is written."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._new_file()

    def begin(self, run_id: str) -> None:
        """Note that a run begins. Raises: `OSError`, for example where the disk is full."""
        self._append({"begin": run_id})

    def end(self, result: Result) -> None:
        """Keep a result. Raises: `OSError`."""
        self._append({"end": result})

    def forgive(self, counts: Counter[str]) -> None:
        """Note that so many begun runs ended with their client, through no fault of theirs."""
        if counts:
            self._append({"forgive": dict(counts)})

    def _new_file(self) -> None:
        name = f"{socket.gethostname()}-{os.getpid()}-{uuid4().hex[:8]}.jsonl"
        self.path = self._folder / name

    def _append(self, entry: dict[str, Any]) -> None:
        line = json.dumps(entry, ensure_ascii=False) + "\n"
        handle = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            rest = line.encode()
            while rest:  # a full disk takes a part, then refuses
                rest = rest[os.write(handle, rest) :]
        except OSError:
            self._new_file()  # nothing is written behind a torn line
            raise
        finally:
            os.close(handle)


@dataclass
class Noted:
    """What all journals of a folder say: results by run, how often a run was begun in vain."""

    results: dict[str, Result] = field(default_factory=dict)
    repeated: list[str] = field(default_factory=list)  # runs that ended more than once
    begun: Counter[str] = field(default_factory=Counter)

    @property
    def broken(self) -> Counter[str]:
        """How often each run without a result was begun and did not end."""
        return Counter({k: n for k, n in self.begun.items() if n > 0 and k not in self.results})


def read_journals(folder: Path, wanted: Iterable[str] | None = None) -> Noted:
    """Return what the journals say, of the `wanted` runs or of all. Raises: `OSError`."""
    noted, only = Noted(), None if wanted is None else set(wanted)
    for path in sorted(folder.glob("*.jsonl")):
        for line in path.read_bytes().split(b"\n"):
            try:
                entry = json.loads(line)
            except ValueError:
                continue  # empty, or torn by a kill
            _note(noted, entry, only)
    return noted


def _note(noted: Noted, entry: dict[str, Any], only: set[str] | None) -> None:
    if "begin" in entry:
        if only is None or entry["begin"] in only:
            noted.begun[entry["begin"]] += 1
    elif "forgive" in entry:
        for run_id, count in entry["forgive"].items():
            noted.begun[run_id] -= count
    else:
        run_id = entry["end"]["id"]
        if only is None or run_id in only:
            if run_id in noted.results:
                noted.repeated.append(run_id)
            noted.results.setdefault(run_id, entry["end"])
