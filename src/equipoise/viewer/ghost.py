"""The reference as a translucent ghost, drawn where it comes out of the robot."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import viser

from equipoise.analysis.rendering.part import Part
from equipoise.spatial import Array
from equipoise.viewer.drawing import Drawing
from equipoise.viewer.layer import Showable

RGB, OPACITY = (60, 130, 255), 0.4
INSET = 0.003  # [m] inwards, so that only what differs from the robot comes out of it


class Ghost(Showable):
    """The parts of `robot` once more, at the reference.

    While every link lies inside its own, nothing of it could be seen, and a page is spared it.
    """

    def __init__(
        self, scene: viser.SceneApi, parts: Sequence[Part], model: pin.Model, robot: Drawing
    ) -> None:
        self._scene, self._parts, self._parents = scene, parts, model.parents
        self._robot = robot
        self._reach = {
            joint: max(
                np.linalg.norm(p.mesh.vertices, axis=1).max() for p in parts if p.joint == joint
            )
            for joint in {part.joint for part in parts}
        }
        self._drawing: Drawing | None = None
        self._wanted, self._outside = True, False
        self._reference = model.createData()
        self._model = model
        self._lock = threading.RLock()

    @property
    def drawn(self) -> bool:
        """Whether it is in the picture."""
        return self._wanted and (self._outside or not self._robot.solid)

    def set_visible(self, visible: bool) -> None:
        """Show it where it comes out, or hide it."""
        with self._lock:
            self._wanted = visible
            self.reconsider()

    def reconsider(self) -> None:
        """Look again whether the robot hides it: the robot itself was shown or hidden."""
        with self._lock:
            if self.drawn:
                if self._drawing is None:
                    self._drawing = Drawing(
                        self._scene,
                        "/ghost",
                        self._parts,
                        self._parents,
                        colour=RGB,
                        opacity=OPACITY,
                        inset=INSET,
                    )
                self._drawing.place(self._reference.oMi)
            if self._drawing is not None:
                self._drawing.set_visible(self.drawn)

    def place(self, q_ref: Array, measured: Sequence[pin.SE3]) -> None:
        """Move it to the reference `q_ref` (nq,), beside the `measured` placements of joints."""
        with self._lock:
            pin.forwardKinematics(self._model, self._reference, q_ref)
            wanted = self._reference.oMi
            self._outside = any(
                farthest(measured[joint], wanted[joint], reach) > INSET
                for joint, reach in self._reach.items()
            )
            self.reconsider()


def farthest(T_one: pin.SE3, T_other: pin.SE3, reach: float) -> float:
    """Return a bound [m] of how far points within `reach` [m] of the origin lie apart."""
    T = T_one.actInv(T_other)
    return float(np.linalg.norm(T.translation) + reach * np.linalg.norm(pin.log3(T.rotation)))
