"""How a robot is controlled, apart from what it is to do."""

from __future__ import annotations

from dataclasses import dataclass, field

from equipoise.control import ControlGains, LoadSplit, ReactionBounds, SupervisorLimits
from equipoise.motion import Governor


@dataclass(frozen=True)
class ControlSettings:
    """How a robot is controlled.

    `period` [s] of a tick; `gains` of the law; `bounds` on the supporting reactions (None: the
    least costly ones); `split` of the load over the soles, by what is "measured" or by where the
    "zmp" is (that is for robots that step); `filter_time` [s] of the reaction observer; `limits` of
    the supervisor; `solver` of the hierarchy, by name; `governor` of the targets' clock (None: it
    is the time).
    """

    gains: ControlGains
    period: float = 0.001
    bounds: ReactionBounds | None = None
    split: LoadSplit = "measured"
    filter_time: float = 0.0
    limits: SupervisorLimits = field(default_factory=SupervisorLimits)
    solver: str = "active_set"
    governor: Governor | None = None
