"""What the codes of the channels `mode` and `status` say, and a run's modes in a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from equipoise.contacts import Phase
from equipoise.runlog import Run
from equipoise.simulation.recorder import CONTROL_CODES, HIERARCHY_CODES, MODE_CODES


def _words(codes: Mapping[Any, float]) -> dict[float, str]:
    return {code: one.name.lower().replace("_", " ") for one, code in codes.items()}


MODES, CONTROL, HIERARCHY = (_words(c) for c in (MODE_CODES, CONTROL_CODES, HIERARCHY_CODES))
PHASES = _words({phase: phase.code for phase in Phase})
PHASE = "walk/phase"
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


def feet_at(run: Run, tick: int) -> tuple[str, ...]:
    """Return a sentence a foot about its phase at a tick; nothing of a run that does not walk."""
    if PHASE not in run:
        return ()
    labels, codes = run.channels[PHASE].labels, run[PHASE][tick]
    values = {phase.code: phase.value for phase in Phase}
    return tuple(
        f"{label} foot: {values.get(float(code), f'unknown ({code:g})')}"
        for label, code in zip(labels, codes, strict=True)
    )


def phases_sentence(run: Run) -> str:
    """Return for how long feet were in phases that nobody planned; empty if none is logged."""
    if PHASE not in run or not run.t.size:
        return ""
    told = []
    for label, codes in zip(run.channels[PHASE].labels, run[PHASE].T, strict=True):
        for phase in (Phase.TOUCHED, Phase.LATE, Phase.LOST):
            share = float((codes == phase.code).mean())
            if share:
                told.append(f"{label} foot {phase.name.lower()} on {100.0 * share:.2g} %")
    return f"Feet: {', '.join(told)} of the ticks." if told else "Feet: as planned on every tick."


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
