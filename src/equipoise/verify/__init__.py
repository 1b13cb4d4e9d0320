"""The paper against the code: a row for each equation and each claim, measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from equipoise.errors import NameNotFoundError
from equipoise.verify import dynamics, geometry, law, metric, motion, promises, switching
from equipoise.verify.evidence import Evidence
from equipoise.verify.row import Check, Measured, Verdict

GROUPS: dict[str, tuple[Check, ...]] = {
    "geometry": geometry.CHECKS,
    "motion": motion.CHECKS,
    "dynamics": dynamics.CHECKS,
    "law": law.CHECKS,
    "promises": promises.CHECKS,
    "metric": metric.CHECKS,
    "switch": switching.CHECKS,
}

__all__ = ["GROUPS", "Check", "Evidence", "Measured", "Verdict", "verify"]


def verify(
    groups: Iterable[str] = tuple(GROUPS), *, report: Callable[[Verdict], None] | None = None
) -> list[Verdict]:
    """Measure every row of the chosen groups, in order; tell `report` about each when it is done.

    Raises: `NameNotFoundError` if a group does not exist.
    """
    chosen = list(groups)
    for group in chosen:
        if group not in GROUPS:
            raise NameNotFoundError("group of checks named", group, GROUPS)
    evidence, verdicts = Evidence(), []
    for group in chosen:
        for check in GROUPS[group]:
            verdict = check.judge(evidence)
            verdicts.append(verdict)
            if report is not None:
                report(verdict)
    return verdicts
