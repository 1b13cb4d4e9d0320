"""The model-free force-motion law: error manifolds, nominal reference, torque, base wrench."""

from equipoise.control.base_wrench.bounded import (
    BoundedDistribution,
    Distribution,
    DistributionStatus,
    ReactionBounds,
)
from equipoise.control.base_wrench.least import distribute_base_wrench
from equipoise.control.base_wrench.observer import (
    ReactionObserver,
    largest_observer_gain,
    observer_delay_margin,
)
from equipoise.control.interface import Measurement, Target
from equipoise.control.passivity.gain_advice import (
    GainAdvice,
    SoftFloorGains,
    advise_for_soft_floor,
    advise_gains,
)
from equipoise.control.passivity.gains import ControlGains
from equipoise.control.passivity.law import Command, ControlStatus, PassivityController
from equipoise.control.passivity.manifolds import ForceManifold, PostureManifold
from equipoise.control.passivity.sign import SignFunction
from equipoise.control.supervisor import Mode, ModeChange, Supervisor, SupervisorLimits
from equipoise.trajectories.profile import Profile

__all__ = [
    "BoundedDistribution",
    "Command",
    "ControlGains",
    "ControlStatus",
    "Distribution",
    "DistributionStatus",
    "ForceManifold",
    "GainAdvice",
    "Measurement",
    "Mode",
    "ModeChange",
    "PassivityController",
    "PostureManifold",
    "Profile",
    "ReactionBounds",
    "ReactionObserver",
    "SignFunction",
    "SoftFloorGains",
    "Supervisor",
    "SupervisorLimits",
    "Target",
    "advise_for_soft_floor",
    "advise_gains",
    "distribute_base_wrench",
    "largest_observer_gain",
    "observer_delay_margin",
]
