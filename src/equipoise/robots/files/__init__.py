"""Readers of robot descriptions (URDF, SRDF, the robot's YAML) and their checks."""
