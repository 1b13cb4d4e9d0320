"""The schema of a study file: what is varied, how points are drawn, who is compared, what is good.

Lengths are in metres, angles in radians, times in seconds, forces in newtons.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from equipoise.scenarios.schema import Limit, Name, Positive, Section
from equipoise.scenarios.schema.base import Title

Path = Annotated[str, Field(min_length=1, max_length=300)]
Overrides = dict[Path, Any]
Numbers = Annotated[list[float], Field(min_length=1, max_length=1000)]
Range = Annotated[list[float], Field(min_length=2, max_length=2)]
Count = Annotated[int, Field(ge=1, le=1_000_000)]
RANGES = ("uniform", "log_uniform")
KINDS = (*RANGES, "grid", "choice")


class ScaledPath(Section):
    """A value of the scenario that is `times` the parameter."""

    path: Path
    times: float = 1.0


class ParameterSpec(Section):
    """What is varied: exactly one of `uniform` and `log_uniform` [low, high], `grid`, `choice`.

    `grid` is a list of numbers in order, `choice` of any values. `path` names the value of the
    scenario that it sets, as `--set` does, `paths` several. `nominal` is its value where it is not
    varied, without one the scenario's.
    """

    uniform: Range | None = None
    log_uniform: Range | None = None
    grid: Numbers | None = None
    choice: Annotated[list[Any], Field(min_length=1, max_length=1000)] | None = None
    path: Path | None = None
    paths: list[ScaledPath] = []
    nominal: float | None = None
    unit: str = ""
    title: Title = ""

    @model_validator(mode="after")
    def _one_kind(self) -> ParameterSpec:
        given = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            raise ValueError(f"give exactly one of {', '.join(KINDS)}")
        if (self.path is None) == (not self.paths):
            raise ValueError("give exactly one of path and paths")
        if given[0] in RANGES:
            low, high = getattr(self, given[0])
            if not low < high:
                raise ValueError(f"{given[0]}: the second number must be larger than the first")
            if given[0] == "log_uniform" and low <= 0.0:
                raise ValueError("log_uniform: both numbers must be larger than 0")
        return self


class SobolSpec(Section):
    """Points of a scrambled Sobol sequence: even in all directions; best are powers of two."""

    kind: Literal["sobol"]
    points: Count
    seed: Annotated[int, Field(ge=0)] = 0


class LatinHypercubeSpec(Section):
    """Points of which every parameter has one in each of as many equal parts of its range."""

    kind: Literal["latin_hypercube"]
    points: Count
    seed: Annotated[int, Field(ge=0)] = 0


class GridSpec(Section):
    """Every combination of the parameters in `over`; the number says how many values of a range.

    `grid` and `choice` have their own values, whatever the number. All others are nominal.
    """

    kind: Literal["grid"]
    over: Annotated[dict[Name, Count], Field(min_length=1)]


class BoundarySpec(Section):
    """Where a run stops being good, by bisection, `steps` times after both ends were tried.

    `along` one parameter: from its nominal value (or the end of its range that is nearer to it) to
    each end of its range that is farther, for every combination of the parameters in `over`, all
    others nominal. `along: each`: every parameter so, alone. `along: all`: all of them together,
    from nominal (scale 0) to each of `points` Sobol points (scale 1).
    """

    kind: Literal["boundary"]
    along: str
    over: dict[Name, Count] = {}
    points: Count | None = None
    steps: Annotated[int, Field(ge=1, le=20)] = 4
    seed: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _fits(self) -> BoundarySpec:
        if (self.along == "all") != (self.points is not None):
            raise ValueError("points belong to along: all, and it needs them")
        if self.over and self.along in ("each", "all"):
            raise ValueError("over belongs to a boundary along one parameter")
        if self.along in self.over:
            raise ValueError("over cannot name the parameter that the boundary is along")
        return self


DesignSpec = Annotated[
    SobolSpec | LatinHypercubeSpec | GridSpec | BoundarySpec, Field(discriminator="kind")
]


class ContenderSpec(Section):
    """One that is compared: what its scenario sets, and a file of gains that `tune` wrote."""

    title: Title = ""
    set: Overrides = {}
    gains: str | None = None


class TlsSpec(Section):
    """Files (PEM) of the certificate authority, of one's own certificate, and of its key."""

    ca: str
    cert: str
    key: str


class EngineSpec(Section):
    """Where the runs run: `cores` of this machine, or a `dask` cluster.

    `workers`: how many; all cores by default. `address` of a scheduler that runs, or `cluster`
    slurm or kubernetes, made with `options` (those of dask-jobqueue or dask-kubernetes). `tls`:
    files of the certificates. `chunk` [s]: how long a worker works before it asks again.
    """

    kind: Literal["cores", "dask"] = "cores"
    workers: Count | None = None
    address: str | None = None
    cluster: Literal["local", "slurm", "kubernetes"] = "local"
    options: dict[str, Any] = {}
    tls: TlsSpec | None = None
    chunk: Positive = 25.0


class StudySpec(Section):
    """A whole study.

    `set` changes the scenario for all. `seeds` runs of each point and controller with noise and
    faults of their own, the same for all controllers. `stands` and `good`: bounds on metrics. A run
    that does not stand is not good. `stop_when_off`: a run ends when the supervisor switches the
    law off; it does not stand anyway. `metrics`: which are kept, besides those that are bounded.
    `logs`: how many runs of a controller that were not good keep their log.
    """

    name: Name
    title: Title = ""
    scenario: str
    robot: str | None = None
    set: Overrides = {}
    controllers: Annotated[dict[Name, ContenderSpec], Field(min_length=1)]
    parameters: Annotated[dict[Name, ParameterSpec], Field(min_length=1, max_length=50)]
    designs: Annotated[dict[Name, DesignSpec], Field(min_length=1)]
    seeds: Annotated[int, Field(ge=1, le=10_000)] = 1
    seed: Annotated[int, Field(ge=0)] = 0
    stands: dict[str, Limit] = {"completed": Limit(min=1.0), "mode_worst": Limit(max=1.0)}
    good: dict[str, Limit] = {}
    metrics: list[str] = ["path_error", "force_error_rms", "base_error", "torque_effort"]
    stop_when_off: bool = True
    logs: Annotated[int, Field(ge=0)] = 10
    engine: EngineSpec = EngineSpec()

    @model_validator(mode="after")
    def _names_exist(self) -> StudySpec:
        for name, design in self.designs.items():
            named = list(getattr(design, "over", {}))
            if isinstance(design, BoundarySpec) and design.along not in ("each", "all"):
                named.append(design.along)
            for parameter in named:
                if parameter not in self.parameters:
                    known = ", ".join(self.parameters)
                    raise ValueError(
                        f"designs.{name}: there is no parameter {parameter!r}; known: {known}"
                    )
            if isinstance(design, BoundarySpec):
                self._check_boundary(name, design)
        for parameter in ("each", "all"):
            if parameter in self.parameters:
                raise ValueError(f"a parameter cannot be called {parameter}")
        return self

    def _check_boundary(self, name: str, design: BoundarySpec) -> None:
        """Refuse a boundary along what has no order, or no nominal value to begin from."""
        single = design.along not in ("each", "all")
        for parameter in [design.along] if single else self.parameters:
            spec = self.parameters[parameter]
            if spec.choice is not None:
                if single:
                    raise ValueError(f"designs.{name}: choices of {parameter} have no order")
            elif spec.nominal is None and not single:
                raise ValueError(f"designs.{name}: parameter {parameter} needs a nominal value")
