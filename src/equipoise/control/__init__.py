"""The model-free force-motion law: error manifolds, nominal reference, torque, base wrench."""

from equipoise.control.adviser import (
    GainAdvice,
    SoftFloorGains,
    advise_for_soft_floor,
    advise_gains,
)
from equipoise.control.base_wrench import distribute_base_wrench
from equipoise.control.gains import ControlGains
from equipoise.control.inputs import Measurement, Target
from equipoise.control.law import Command, ControlStatus, PassivityController
from equipoise.control.manifolds import ForceManifold, PostureManifold
from equipoise.control.profile import Profile
from equipoise.control.reaction_observer import (
    ReactionObserver,
    largest_observer_gain,
    observer_delay_margin,
)
from equipoise.control.reaction_qp import (
    BoundedDistribution,
    Distribution,
    DistributionStatus,
    ReactionBounds,
)
from equipoise.control.signum import SignFunction
from equipoise.control.supervisor import Mode, ModeChange, Supervisor, SupervisorLimits

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
