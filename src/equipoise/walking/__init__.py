"""Walking: footsteps, the centre of mass over them, swings, and the phases of a step."""

from equipoise.walking.balance import BalanceFeedback, BalanceSettings
from equipoise.walking.clock import WalkClock
from equipoise.walking.events import WalkEvent
from equipoise.walking.feasible import WalkLimits, require_feasible
from equipoise.walking.feet import LEFT, RIGHT, Feet
from equipoise.walking.footsteps import (
    Footstep,
    Stride,
    StrideLimits,
    closing_step,
    steps_along,
    steps_to,
)
from equipoise.walking.leaning import Leaning
from equipoise.walking.plan import PlannedStep, WalkPlan, WalkPlanner
from equipoise.walking.settings import TouchSettings, WalkMode, WalkSettings
from equipoise.walking.steered import SteeredWalk
from equipoise.walking.stick import Clip, Stick, StickSchedule
from equipoise.walking.swing import Swing, SwingShape
from equipoise.walking.targets import LedPose, WalkTargets
from equipoise.walking.timing import WalkTiming
from equipoise.walking.walker import Walker

__all__ = [
    "LEFT",
    "RIGHT",
    "BalanceFeedback",
    "BalanceSettings",
    "Clip",
    "Feet",
    "Footstep",
    "Leaning",
    "LedPose",
    "PlannedStep",
    "SteeredWalk",
    "Stick",
    "StickSchedule",
    "Stride",
    "StrideLimits",
    "Swing",
    "SwingShape",
    "TouchSettings",
    "WalkClock",
    "WalkEvent",
    "WalkLimits",
    "WalkMode",
    "WalkPlan",
    "WalkPlanner",
    "WalkSettings",
    "WalkTargets",
    "WalkTiming",
    "Walker",
    "closing_step",
    "require_feasible",
    "steps_along",
    "steps_to",
]
