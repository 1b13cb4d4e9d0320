"""Pictures of robot and world by MuJoCo's renderer, without a display."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.errors import EquipoiseError
from equipoise.physics.mujoco.engine import MujocoEngine
from equipoise.spatial import Array


class NoPictureError(EquipoiseError):
    """This machine gives MuJoCo no way to draw."""


def choose_offscreen() -> None:
    """Ask MuJoCo for EGL, which needs no display; must be called before mujoco is imported."""
    os.environ.setdefault("MUJOCO_GL", "egl")


class MujocoView:
    """Draws states of an engine's model; close it when done.

    Raises: `NoPictureError` if there is no way to draw here.
    """

    def __init__(self, engine: MujocoEngine, width: int = 960, height: int = 720) -> None:
        self._engine = engine
        self._mujoco: Any = engine.mujoco
        compiled = engine.model.compiled
        compiled.vis.global_.offwidth = max(width, compiled.vis.global_.offwidth)
        compiled.vis.global_.offheight = max(height, compiled.vis.global_.offheight)
        try:
            self._renderer = self._mujoco.Renderer(compiled, height, width)
        except Exception as error:  # GL libraries raise what they like
            raise NoPictureError(f"MuJoCo cannot draw here ({error})") from error
        self._camera = self._mujoco.MjvCamera()
        self._camera.distance, self._camera.azimuth, self._camera.elevation = 2.6, 140.0, -14.0

    def image(self, q: Array, objects: Mapping[str, pin.SE3]) -> Array:
        """Return the picture (height, width, 3) [0..255] of the robot at `q` (nq,)."""
        simulated, compiled = self._engine.simulated, self._engine.model.compiled
        self._engine.model.conversion.write_q(q, simulated.qpos)
        for name, T in objects.items():
            self._engine.objects.put(name, T)
        self._mujoco.mj_kinematics(compiled, simulated)
        self._mujoco.mj_camlight(compiled, simulated)
        self._camera.lookat[:] = np.array([q[0] + 0.15, q[1], 0.75])
        self._renderer.update_scene(simulated, self._camera)
        return self._renderer.render()

    def close(self) -> None:
        """Give the renderer back."""
        self._renderer.close()
