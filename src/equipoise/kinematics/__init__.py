"""Kinematics of one robot at one state, and live views into the libraries that compute it."""

from equipoise.kinematics.state import (
    Kinematics,
    KinematicsEvaluator,
    LiveArrays,
    StaleKinematicsError,
)

__all__ = ["Kinematics", "KinematicsEvaluator", "LiveArrays", "StaleKinematicsError"]
