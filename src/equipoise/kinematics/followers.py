"""Joints that follow another by an affine law: which they are in a model, and the model without it.

A mechanism that ties joint f to its leader l, `q_f = ratio q_l + offset`, has the coordinates of
the leaders only. With `v = G v_r` power stays what it was: `tau_r = G^T tau`, and the inertia
matrix is `G^T M G`, for G is constant. Pinocchio calls a follower a mimic joint.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.spatial import Array

MIMIC = "JointModelMimic"


class Follower(NamedTuple):
    """`joint` is at `ratio` times the coordinate of its leader and `offset`; all by number."""

    joint: int
    leader: int
    ratio: float
    offset: float


def followers_of(model: pin.Model) -> tuple[Follower, ...]:
    """Return the joints that follow another one, in the order of the joints."""
    found = []
    for joint in range(1, model.njoints):
        one = model.joints[joint]
        if one.shortname() == MIMIC:
            law = one.extract()
            leader = next(j for j in moving_joints(model) if model.joints[j].idx_v == one.idx_v)
            found.append(Follower(joint, leader, float(law.scaling), float(law.offset)))
    return tuple(found)


def moving_joints(model: pin.Model) -> list[int]:
    """Return the joints that have coordinates of their own, in the order of these."""
    return [j for j in range(1, model.njoints) if model.joints[j].nv > 0]


def moved_by(model: pin.Model, joint: int) -> list[int]:
    """Return the velocities that move a joint's body, each once, from the base on."""
    found: dict[int, None] = {}
    for j in list(model.supports[joint])[1:]:
        one = model.joints[j]
        found.update(dict.fromkeys(range(one.idx_v, one.idx_v + max(one.nv, 1))))
    return list(found)


def axes_of(model: pin.Model) -> Array:
    """Return (njoints, 6) the twist in its own axes of each joint of one coordinate at unit speed.

    That of a follower is at a unit of its own speed, not of its leader's.
    """
    axes, memory = np.zeros((model.njoints, 6)), model.createData()
    ratio = {one.joint: one.ratio for one in followers_of(model)}
    for joint in range(1, model.njoints):
        subspace = np.asarray(memory.joints[joint].S)
        if subspace.size == axes.shape[1]:
            axes[joint] = subspace.ravel() / ratio.get(joint, 1.0)
    return axes


class Uncoupled:
    """The model in which every joint moves by itself, without frames and armature.

    `G` (its nv, nv of the coupled model) spreads velocities, `spread` configurations.
    """

    def __init__(self, coupled: pin.Model, model: pin.Model, where: Mapping[int, int]) -> None:
        self.model, self._q = model, np.zeros(model.nq)
        self.G = np.zeros((model.nv, coupled.nv))
        own: list[tuple[int, int]] = []
        for joint in moving_joints(coupled):
            ours, theirs = coupled.joints[joint], model.joints[where[joint]]
            own += [(theirs.idx_q + k, ours.idx_q + k) for k in range(ours.nq)]
            for k in range(ours.nv):
                self.G[theirs.idx_v + k, ours.idx_v + k] = 1.0
        laws: list[tuple[int, int, float, float]] = []
        for one in followers_of(coupled):
            ours, theirs = coupled.joints[one.joint], model.joints[where[one.joint]]
            laws.append((theirs.idx_q, ours.idx_q, one.ratio, one.offset))
            self.G[theirs.idx_v, ours.idx_v] = one.ratio
        self._own, self._laws = np.array(own), laws

    def spread(self, q: Array) -> Array:
        """Return the configuration that belongs to q of the coupled model."""
        out = self._q
        out[self._own[:, 0]] = q[self._own[:, 1]]
        for at, leader, ratio, offset in self._laws:
            out[at] = ratio * q[leader] + offset
        return out.copy()


def uncoupled(model: pin.Model) -> Uncoupled:
    """Return the model without its couplings."""
    whole, axes, where = pin.Model(), axes_of(model), {0: 0}
    whole.gravity = model.gravity
    for joint in _by_branch(model):
        kind = model.joints[joint]
        if kind.shortname() == MIMIC:
            turning = np.abs(axes[joint, 3:]).max() > 0.0
            kind = (
                pin.JointModelRevoluteUnaligned(axes[joint, 3:])
                if turning
                else pin.JointModelPrismaticUnaligned(axes[joint, :3])
            )
        place, name = model.jointPlacements[joint], model.names[joint]
        added = whole.addJoint(where[model.parents[joint]], kind, place, name)
        whole.inertias[added], where[joint] = model.inertias[joint], added
    return Uncoupled(model, whole, where)


def _by_branch(model: pin.Model) -> list[int]:
    """Return the joints along each branch to its end: what Pinocchio's algorithms ask for."""
    order: list[int] = []
    children: dict[int, list[int]] = {}
    for joint in range(model.njoints - 1, 0, -1):
        children.setdefault(model.parents[joint], []).append(joint)
    left = list(children.get(0, []))
    while left:
        order.append(left.pop())
        left += children.get(order[-1], [])
    return order
