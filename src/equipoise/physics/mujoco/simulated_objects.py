"""The loose objects of a running simulation: where they are and what still holds them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.errors import NameNotFoundError
from equipoise.physics.mujoco.conversion import placement, quat_wxyz
from equipoise.physics.mujoco.names import of_object
from equipoise.physics.mujoco.objects import LooseObject
from equipoise.physics.mujoco.world_model import weld_name
from equipoise.spatial import Array


@dataclass(frozen=True)
class _Place:
    """Where an object stands in MuJoCo's arrays, and where they are: views."""

    dof: int
    position: Array  # (3,) [m], after the last step's kinematics
    wxyz: Array  # (4,)
    qpos: Array  # (7,)
    qvel: Array  # (6,)


class SimulatedObjects:
    """Looks at the loose objects in MuJoCo's memory, by their own names."""

    def __init__(self, compiled: Any, simulated: Any, objects: Sequence[LooseObject]) -> None:
        self.names = tuple(loose.name for loose in objects)
        self._places = {name: _place(compiled, simulated, name) for name in self.names}
        self.sliding = [
            (self._places[loose.name].dof, loose.viscosity)
            for loose in objects
            if loose.viscosity > 0.0
        ]
        self._active = simulated.eq_active
        self._welds = [
            (loose.let_go, _welds(compiled, loose)) for loose in objects if loose.handles
        ]

    def position(self, name: str) -> Array:
        """Return where an object's origin is (3,) [m], a view that moves with it."""
        return self._of(name).position

    def pose(self, name: str) -> pin.SE3:
        """Return where an object is in the world. Raises: `NameNotFoundError`."""
        place = self._of(name)
        return placement(place.position, place.wxyz)

    def twist(self, name: str) -> Array:
        """Return linear [m/s] and angular velocity [rad/s] (6,), world axes.

        Raises: `NameNotFoundError`.
        """
        qvel = self._of(name).qvel
        return np.concatenate((qvel[:3], self.pose(name).rotation @ qvel[3:]))

    def put(self, name: str, T: pin.SE3) -> None:
        """Write another pose of an object. Raises: `NameNotFoundError`."""
        qpos = self._of(name).qpos
        qpos[:3], qpos[3:] = T.translation, quat_wxyz(T.rotation)

    def let_go(self, t: float) -> None:
        """Open the welds whose time [s] has come."""
        for opens, welds in self._welds:
            if t >= opens:
                self._active[welds] = 0

    def _of(self, name: str) -> _Place:
        try:
            return self._places[name]
        except KeyError:
            raise NameNotFoundError("loose object", name, self.names) from None


def _place(compiled: Any, simulated: Any, name: str) -> _Place:
    body, joint = compiled.body(of_object(name)).id, compiled.joint(of_object(name))
    at, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
    return _Place(
        dof,
        simulated.xpos[body],
        simulated.xquat[body],
        simulated.qpos[at : at + 7],
        simulated.qvel[dof : dof + 6],
    )


def _welds(compiled: Any, loose: LooseObject) -> list[int]:
    return [compiled.equality(weld_name(loose.name, k)).id for k in range(len(loose.handles))]
