"""The whole controller in one object, and the tick that runs it."""

from equipoise.wbc.controller import (
    ControlSettings,
    NewController,
    WholeBodyCommand,
    WholeBodyController,
)

__all__ = ["ControlSettings", "NewController", "WholeBodyCommand", "WholeBodyController"]
