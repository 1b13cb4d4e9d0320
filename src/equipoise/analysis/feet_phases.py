"""What the codes of the channel `walk/phase` say: of a tick, and of a whole run."""

from __future__ import annotations

from equipoise.contacts import Phase
from equipoise.runlog import Run

PHASE = "walk/phase"
PHASES = {phase.code: phase.name.lower() for phase in Phase}
PLANNED = (Phase.HELD, Phase.FREE)


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
        for phase in (one for one in Phase if one not in PLANNED):
            share = float((codes == phase.code).mean())
            if share:
                told.append(f"{label} foot {phase.name.lower()} on {100.0 * share:.2g} %")
    return f"Feet: {', '.join(told)} of the ticks." if told else "Feet: as planned on every tick."
