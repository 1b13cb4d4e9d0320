"""The model-free force-motion law: error manifolds, nominal reference, torque, base wrench."""

from equipoise.control.adviser import GainAdvice, advise_gains
from equipoise.control.base_wrench import distribute_base_wrench
from equipoise.control.gains import ControlGains
from equipoise.control.law import Command, ControlStatus, Measurement, PassivityController, Target
from equipoise.control.manifolds import ForceManifold, PostureManifold
from equipoise.control.profile import Profile
from equipoise.control.signum import SignFunction

__all__ = [
    "Command",
    "ControlGains",
    "ControlStatus",
    "ForceManifold",
    "GainAdvice",
    "Measurement",
    "PassivityController",
    "PostureManifold",
    "Profile",
    "SignFunction",
    "Target",
    "advise_gains",
    "distribute_base_wrench",
]
