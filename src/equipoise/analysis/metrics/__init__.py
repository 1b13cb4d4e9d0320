"""The numbers that tell how a run went, and what they are judged by."""

from equipoise.analysis.metrics.base import Metric
from equipoise.analysis.metrics.registry import METRICS, compute_metrics
from equipoise.analysis.metrics.verdict import check_acceptance, impossible, judge, passed

__all__ = [
    "METRICS",
    "Metric",
    "check_acceptance",
    "compute_metrics",
    "impossible",
    "judge",
    "passed",
]
