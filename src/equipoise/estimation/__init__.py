"""What a robot does not measure, estimated: where its base is, and what acts in its contacts."""

from equipoise.estimation.base_filter import BaseFilter, FilterNoise
from equipoise.estimation.estimating_robot import EstimatingRobot
from equipoise.estimation.wrench_observer import WrenchObserver

__all__ = ["BaseFilter", "EstimatingRobot", "FilterNoise", "WrenchObserver"]
