"""Gymnasium: an agent sets targets of hands and wanted forces, the controller does the rest.

Importing it registers `equipoise/Reach-v0`. It needs the extra `gym`.
"""

from equipoise.gym.library import require_gymnasium

require_gymnasium()

from equipoise.gym.env import WholeBodyEnv  # noqa: E402  after what it needs is known to be there
from equipoise.gym.episode import Episode  # noqa: E402
from equipoise.gym.register import register  # noqa: E402

register()

__all__ = ["Episode", "WholeBodyEnv"]
