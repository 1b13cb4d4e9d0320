"""The name under which `gymnasium.make` finds the environment."""

from __future__ import annotations

import gymnasium

NAME = "equipoise/Reach-v0"


def register() -> None:
    """Register the environment, once."""
    if NAME not in gymnasium.registry:
        gymnasium.register(id=NAME, entry_point="equipoise.gym.env:WholeBodyEnv")
