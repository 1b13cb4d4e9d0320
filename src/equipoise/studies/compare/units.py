"""What numbers of a study are called, and the unit in which they are shown."""

from __future__ import annotations

import numpy as np

from equipoise.analysis.metrics import METRICS
from equipoise.scenarios.schema import Limit
from equipoise.studies.draw import ends_of
from equipoise.studies.schema import StudySpec

SHOWN = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}
NAMES = {
    "path_error": "palm error",
    "force_error_rms": "force error",
    "base_error": "base error",
    "torque_effort": "effort",
    "palm_position_error": "palm error",
    "posture_error": "posture error",
    "torque_share": "torque share",
}


def scaled(metric: str, values: np.ndarray) -> np.ndarray:
    """Return values of a metric in the unit in which it is shown."""
    factor, _ = SHOWN.get(METRICS[metric].unit, (1.0, ""))
    return factor * np.asarray(values, float)


def metric_label(metric: str) -> str:
    """Return the name of a metric with its unit."""
    unit = METRICS[metric].unit
    _, unit = SHOWN.get(unit, (1.0, unit))
    name = NAMES.get(metric, metric.replace("_", " "))
    return f"{name} [{unit}]" if unit else name


def parameter_label(study: StudySpec, name: str) -> str:
    """Return the title of a parameter with its unit."""
    spec = study.parameters[name]
    title = spec.title or name.replace("_", " ")
    return f"{title} [{spec.unit}]" if spec.unit else title


def spoke_name(study: StudySpec, spoke: str) -> str:
    """Return the name of a line along one parameter; its direction where there are two."""
    parameter, sign = spoke[:-1], spoke[-1]
    spec = study.parameters[parameter]
    low, high = ends_of(spec)
    two = spec.nominal is not None and low < spec.nominal < high
    word = {"+": "more ", "-": "less "}[sign] if two else ""
    return word + parameter.replace("_", " ")


def bound_text(metric: str, limit: Limit) -> str:
    """Return in words what a bound on a metric wants, in the unit in which it is shown."""
    factor, unit = SHOWN.get(METRICS[metric].unit, (1.0, METRICS[metric].unit))
    bounds = [
        (sign, value) for sign, value in (("≤", limit.max), ("≥", limit.min)) if value is not None
    ]
    told = " and ".join(f"{sign} {factor * value:g}" for sign, value in bounds)
    return f"{NAMES.get(metric, metric.replace('_', ' '))} {told} {unit}".rstrip()
