"""What the codes of the channels `mode` and `status` say, and a run's modes in a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from equipoise.runlog import Run
from equipoise.simulation.recorder import CONTROL_CODES, HIERARCHY_CODES, MODE_CODES


def _words(codes: Mapping[Any, float]) -> dict[float, str]:
    return {code: one.name.lower().replace("_", " ") for one, code in codes.items()}


MODES, CONTROL, HIERARCHY = (_words(c) for c in (MODE_CODES, CONTROL_CODES, HIERARCHY_CODES))
MOST_CHANGES = 6  # that a sentence lists


def word_of(words: Mapping[float, str], code: float) -> str:
    """Return the word of a logged code."""
    return words.get(float(code), f"unknown ({code:g})")


def modes_sentence(run: Run) -> str:
    """Return which mode the supervisor was in from when on; empty if it was not logged."""
    if "mode" not in run or not run.t.size:
        return ""
    mode = run["mode"][:, 0]
    changes = [0, *(np.flatnonzero(np.diff(mode)) + 1)]
    if len(changes) == 1:
        return f"Supervisor: {word_of(MODES, mode[0])} throughout."
    told = [f"{word_of(MODES, mode[k])} from {run.t[k]:.3f} s" for k in changes[:MOST_CHANGES]]
    rest = len(changes) - MOST_CHANGES
    more = f" and {rest} more changes" if rest > 0 else ""
    return f"Supervisor: {', '.join(told)}{more}."


def status_sentence(run: Run) -> str:
    """Return how often law and hierarchy were not well; empty if it was not logged."""
    if "status" not in run or not run.t.size:
        return ""
    told = []
    for what, words, codes in zip(
        ("law", "hierarchy"), (CONTROL, HIERARCHY), run["status"].T, strict=True
    ):
        for code, count in zip(*np.unique(codes[codes != 0.0], return_counts=True), strict=True):
            told.append(f"{what} {word_of(words, code)} on {100.0 * count / len(codes):.2g} %")
    return f"Ticks: {', '.join(told)}." if told else "Law and hierarchy: well on every tick."
