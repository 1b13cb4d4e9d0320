"""The schema of a tuning file: which gains are looked for, on which runs, judged on which."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from equipoise.scenarios.gains_file import SECTION
from equipoise.scenarios.schema import Limit, Name, Positive, Section
from equipoise.scenarios.schema.base import Title
from equipoise.studies.schema import (
    ContenderSpec,
    Count,
    EngineSpec,
    GridSpec,
    LatinHypercubeSpec,
    Overrides,
    ParameterSpec,
    Path,
    Range,
    SobolSpec,
    StudySpec,
)

ADVISER, TUNED = "adviser", "tuned"
ENSEMBLE, HOLD_OUT = "ensemble", "hold_out"

PointsSpec = Annotated[SobolSpec | LatinHypercubeSpec | GridSpec, Field(discriminator="kind")]


class GainRangeSpec(Section):
    """Where a gain is looked for: exactly one of `uniform`, `log_uniform` [low, high], `choice`."""

    uniform: Range | None = None
    log_uniform: Range | None = None
    choice: Annotated[list[Any], Field(min_length=2)] | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> GainRangeSpec:
        kinds = ("uniform", "log_uniform", "choice")
        if sum(getattr(self, kind) is not None for kind in kinds) != 1:
            raise ValueError(f"give exactly one of {', '.join(kinds)}")
        numbers = self.uniform or self.log_uniform
        if numbers is not None and not numbers[0] < numbers[1]:
            raise ValueError("the second number must be larger than the first")
        if self.log_uniform is not None and self.log_uniform[0] <= 0.0:
            raise ValueError("log_uniform: both numbers must be larger than 0")
        return self


class TuneSpec(Section):
    """A whole tuning file.

    `gains`: ranges by their path in the scenario; `fixed`: what is set with them. `adviser`: what
    the gains are compared with sets, nothing by default. `ensemble` and `hold_out` are points of
    the `parameters`, and must differ. `cost` weighs the logarithms of metrics, each over the
    adviser's median on the ensemble; a run that does not stand costs `fall`, more if it falls
    early. Gains are taken if on the hold-out they cost less and stand and are good no less often.
    """

    name: Name
    title: Title = ""
    scenario: str
    robot: str | None = None
    set: Overrides = {}
    gains: Annotated[dict[Path, GainRangeSpec], Field(min_length=1)]
    fixed: Overrides = {}
    adviser: Overrides = {}
    parameters: Annotated[dict[Name, ParameterSpec], Field(min_length=1)]
    ensemble: PointsSpec
    hold_out: PointsSpec
    seeds: Annotated[int, Field(ge=1, le=1000)] = 1
    seed: Annotated[int, Field(ge=0)] = 0
    stands: dict[str, Limit] = {"completed": Limit(min=1.0), "mode_worst": Limit(max=1.0)}
    good: dict[str, Limit] = {}
    cost: Annotated[dict[str, Positive], Field(min_length=1)] = {"path_error": 1.0}
    fall: Positive = 5.0
    trials: Count = 100
    engine: EngineSpec = EngineSpec()

    @model_validator(mode="after")
    def _honest(self) -> TuneSpec:
        if self.ensemble == self.hold_out:
            raise ValueError("the hold-out must be other points than the ensemble: another seed")
        for section in ("gains", "fixed", "adviser"):
            for path in getattr(self, section):
                if not path.startswith(f"{SECTION}."):
                    raise ValueError(f"{section}: {path} does not belong to {SECTION}")
        return self

    def study(self) -> StudySpec:
        """Return the study whose runs are done: faults and gains are its parameters."""
        gains = {
            gain_name(k): ParameterSpec(path=path, **gain.model_dump())
            for k, (path, gain) in enumerate(self.gains.items())
        }
        return StudySpec(
            name=self.name,
            title=self.title,
            scenario=self.scenario,
            robot=self.robot,
            set=self.set,
            controllers={
                ADVISER: ContenderSpec(set=self.adviser),
                TUNED: ContenderSpec(set=self.fixed),
            },
            parameters={**self.parameters, **gains},
            designs={ENSEMBLE: self.ensemble, HOLD_OUT: self.hold_out},
            seeds=self.seeds,
            seed=self.seed,
            stands=self.stands,
            good=self.good,
            metrics=list(self.cost),
            logs=0,
            engine=self.engine,
        )


def gain_name(k: int) -> str:
    """Return the name of the k-th gain among the parameters."""
    return f"gain_{k}"
