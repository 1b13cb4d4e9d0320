"""What the law is given every tick: a measurement and a target, checked and copied."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.errors import ShapeError
from equipoise.robots import Robot
from equipoise.spatial import Array

_INPUTS = (
    *("measured q", "measured v", "measured lam"),
    *("target q_ref", "target v_ref", "target lam_ref"),
)


class Measurement(NamedTuple):
    """What sensors give: `q` (nq,), `v` (nv,), `lam` (r,) of the stacked contacts."""

    q: Array
    v: Array
    lam: Array


class Target(NamedTuple):
    """What is wanted now: `q_ref` (nq,), `v_ref` (nv,), `lam_ref` (k,) of the regulated rows."""

    q_ref: Array
    v_ref: Array
    lam_ref: Array


class Inputs:
    """Measurement and target in the one memory layout that the kernels are compiled for."""

    def __init__(self, robot: Robot, contacts: ContactStack) -> None:
        nq, nv, k = robot.nq, robot.nv, contacts.regulated_rows.size
        sizes = (nq, nv, contacts.size, nq, nv, k)
        self._shapes = tuple((size,) for size in sizes)
        self._memory = np.zeros(sum(sizes))
        parts = np.split(self._memory, np.cumsum(sizes)[:-1])
        self.measured, self.target = Measurement(*parts[:3]), Target(*parts[3:])

    def take(self, measured: Measurement, target: Target) -> None:
        """Copy both. Raises: `ShapeError`."""
        given = (measured.q, measured.v, measured.lam, target.q_ref, target.v_ref, target.lam_ref)
        for array, shape, name in zip(given, self._shapes, _INPUTS, strict=True):
            if array.shape != shape:
                raise ShapeError(name, array.shape, shape)
        np.concatenate(given, out=self._memory)
