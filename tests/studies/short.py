"""A study of a few runs of a tenth of a second, on rigid contacts, for tests that really run it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from equipoise.studies.read import read_study
from equipoise.studies.schema import StudySpec

TEXT = """
name: short
scenario: press
set: {duration: 0.1, acceptance.after: 0.05}
controllers:
  quick: {title: quick gains}
  slow: {set: {control.gains.alpha: 5.0}}
parameters:
  mass: {path: disturbances.mass_scale, log_uniform: [0.7, 1.4], nominal: 1.0}
  delay: {path: faults.measurement_delay, uniform: [0.0, 0.004], nominal: 0.0, unit: s}
designs:
  main: {kind: sobol, points: 4}
  edge: {kind: boundary, along: mass, steps: 1}
good: {base_error: {max: 0.00002}}
"""


def short(folder: Path, *overrides: str, **more: Any) -> StudySpec:
    """Return the study, from a file in a folder."""
    file = folder / "short.yaml"
    file.write_text(TEXT, encoding="utf-8")
    return read_study(str(file), overrides, **more)
