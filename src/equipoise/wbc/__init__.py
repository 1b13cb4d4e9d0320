"""The whole controller in one object, and the tick that runs it."""

from equipoise.wbc.command import WholeBodyCommand
from equipoise.wbc.controller import NewController, WholeBodyController
from equipoise.wbc.doors import LoopSettings
from equipoise.wbc.losses import LossGuard
from equipoise.wbc.settings import ControlSettings

__all__ = [
    "ControlSettings",
    "LoopSettings",
    "LossGuard",
    "NewController",
    "WholeBodyCommand",
    "WholeBodyController",
]
