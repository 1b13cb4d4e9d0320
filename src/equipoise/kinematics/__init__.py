"""Kinematics of one robot at one state, by kernels that the tick shares."""

from equipoise.kinematics.state import (
    Kinematic,
    Kinematics,
    KinematicsEvaluator,
    StaleKinematicsError,
    kinematics_at,
)

__all__ = [
    "Kinematic",
    "Kinematics",
    "KinematicsEvaluator",
    "StaleKinematicsError",
    "kinematics_at",
]
