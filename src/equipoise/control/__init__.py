"""The model-free force-motion law: error manifolds, nominal reference, torque, base wrench."""

from equipoise.control.base_wrench.bounded import (
    BoundedDistribution,
    Distribution,
    DistributionStatus,
)
from equipoise.control.base_wrench.foot_bounds import ReactionBounds
from equipoise.control.base_wrench.least import distribute_base_wrench
from equipoise.control.base_wrench.observer import (
    ReactionObserver,
    largest_observer_gain,
    observer_delay_margin,
)
from equipoise.control.interface import (
    Command,
    Controller,
    ControlStatus,
    Measurement,
    Reference,
)
from equipoise.control.kinds import CONTROLLERS, register_controller
from equipoise.control.modes import Mode, ModeChange, SupervisorLimits
from equipoise.control.passivity.gain_advice import (
    GainAdvice,
    SoftFloorGains,
    advise_for_postures,
    advise_for_soft_floor,
    advise_gains,
    bear_postures,
)
from equipoise.control.passivity.gains import ControlGains, Projector
from equipoise.control.passivity.law import Keep, PassivityController
from equipoise.control.passivity.manifolds import ForceManifold, PostureManifold
from equipoise.control.passivity.nearest import NearestVelocity
from equipoise.control.passivity.program import LoadSplit
from equipoise.control.passivity.sign import SignFunction
from equipoise.control.supervisor import Supervisor
from equipoise.renamed import old_names_of

__all__ = [
    "CONTROLLERS",
    "BoundedDistribution",
    "Command",
    "ControlGains",
    "ControlStatus",
    "Controller",
    "Distribution",
    "DistributionStatus",
    "ForceManifold",
    "GainAdvice",
    "Keep",
    "LoadSplit",
    "Measurement",
    "Mode",
    "ModeChange",
    "NearestVelocity",
    "PassivityController",
    "PostureManifold",
    "Projector",
    "ReactionBounds",
    "ReactionObserver",
    "Reference",
    "SignFunction",
    "SoftFloorGains",
    "Supervisor",
    "SupervisorLimits",
    "advise_for_postures",
    "advise_for_soft_floor",
    "advise_gains",
    "bear_postures",
    "distribute_base_wrench",
    "largest_observer_gain",
    "observer_delay_margin",
    "register_controller",
]

__getattr__ = old_names_of(__name__)
