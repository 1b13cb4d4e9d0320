"""Adapters to loops of one's own: they do the conventions of another program, and nothing else."""

from equipoise.adapters.mujoco import MujocoAdapter, MujocoState

__all__ = ["MujocoAdapter", "MujocoState"]
