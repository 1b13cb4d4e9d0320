"""What a run must show."""

from __future__ import annotations

from pydantic import model_validator

from equipoise.scenarios.schema.base import NotNegative, Section


class Limit(Section):
    """Bounds on one metric of the finished run."""

    max: float | None = None
    min: float | None = None

    @model_validator(mode="after")
    def _some_bound(self) -> Limit:
        if self.max is None and self.min is None:
            raise ValueError("give max or min")
        return self


class AcceptanceSpec(Section):
    """What the run must show: `after` is where the settled part begins, `limits` by metric name."""

    after: NotNegative = 1.0
    limits: dict[str, Limit] = {}
