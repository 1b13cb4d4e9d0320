"""Makes joints of a built model follow others: fewer coordinates, the same bodies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.errors import RobotFileError, quoted
from equipoise.robots.files.described import Described
from equipoise.robots.files.finding import WARNING, Finding
from equipoise.robots.files.laws import Law
from equipoise.robots.files.values import LIMIT_SLACK

# what a follower adds to its leader, by the power of its ratio
ADDED = {"armature": 2, "damping": 2, "upperDryFrictionLimit": 1}
KEPT = (
    *("armature", "damping", "upperDryFrictionLimit", "lowerDryFrictionLimit"),
    *("lowerEffortLimit", "lowerVelocityLimit", "rotorInertia", "rotorGearRatio"),
)


def couple(described: Described) -> None:
    """Let the joints of `described.laws` follow: `q = G q_r + offset`, `v = G v_r`.

    A leader moves within the limits of position and speed of all that follow it, its motor has to
    move their armature, damping and friction too: `G^T D G`. Its torque is its own.
    Raises: RobotFileError for a joint that follows one that hangs on it.
    """
    laws = described.laws
    if not laws:
        return
    limits = _limits_with_followers(described)
    _lead_first(described, laws)
    model = described.model
    for law in laws:
        leader, follower = model.getJointId(law.leader), model.getJointId(law.follower)
        model = pin.transformJointIntoMimic(model, leader, follower, law.ratio, law.offset)
    for name, values in limits.items():
        one = model.joints[model.getJointId(name)]
        for key, value in values.items():
            at = one.idx_q if key.endswith("PositionLimit") else one.idx_v
            getattr(model, key)[at] = value
    described.model = model
    described.coupled |= {law.follower for law in laws}
    for posture in described.postures.values():
        for law in laws:
            posture.pop(law.follower, None)


def _limits_with_followers(described: Described) -> dict[str, dict[str, float]]:
    """Return by leader what its followers make of its limits and losses."""
    model = described.model
    found: dict[str, dict[str, float]] = {}
    for law in described.laws:
        one, other = (model.joints[model.getJointId(n)] for n in (law.leader, law.follower))
        if law.leader not in found:
            found[law.leader] = {
                "lowerPositionLimit": float(model.lowerPositionLimit[one.idx_q]),
                "upperPositionLimit": float(model.upperPositionLimit[one.idx_q]),
                "upperVelocityLimit": float(model.upperVelocityLimit[one.idx_v]),
                **{key: float(getattr(model, key)[one.idx_v]) for key in ADDED},
            }
        mine = found[law.leader]
        ends = sorted(
            (float(q[other.idx_q]) - law.offset) / law.ratio
            for q in (model.lowerPositionLimit, model.upperPositionLimit)
        )
        low = max(mine["lowerPositionLimit"], ends[0])
        high = min(mine["upperPositionLimit"], ends[1])
        if high - low > LIMIT_SLACK:
            mine["lowerPositionLimit"], mine["upperPositionLimit"] = low, high
        else:
            described.findings.append(
                Finding(
                    WARNING,
                    f"joint {law.follower!r}",
                    f"its limits leave {quoted(law.leader)}, which it follows, no room: those of "
                    "that one are taken alone",
                    remedy="Correct them (limits, in the robot's YAML)",
                )
            )
        speed = float(model.upperVelocityLimit[other.idx_v]) / abs(law.ratio)
        mine["upperVelocityLimit"] = min(mine["upperVelocityLimit"], speed)
        for key, power in ADDED.items():
            mine[key] += abs(law.ratio) ** power * float(getattr(model, key)[other.idx_v])
    for mine in found.values():
        mine["lowerVelocityLimit"] = -mine["upperVelocityLimit"]
        mine["lowerDryFrictionLimit"] = -mine["upperDryFrictionLimit"]
    return found


def _lead_first(described: Described, laws: Sequence[Law]) -> None:
    """Put the joints into an order in which a leader comes before those that follow it."""
    model = described.model
    leader = {model.getJointId(law.follower): model.getJointId(law.leader) for law in laws}
    order: list[int] = []
    left = list(range(1, model.njoints))
    while left:
        placed = {joint: k for k, joint in enumerate((0, *order))}
        ready = [j for j in left if model.parents[j] in placed and leader.get(j, 0) in placed]
        if not ready:
            stuck = next(law for law in laws if model.getJointId(law.follower) in left)
            raise RobotFileError(
                f"joint {quoted(stuck.follower)} follows {quoted(stuck.leader)}, which hangs on it",
                remedy="Lock one of them in the robot's YAML (locked), or couple them the other "
                "way round",
            )
        # along a branch to its end, where the leaders allow it, as the order was before
        order.append(max(ready, key=lambda j: (placed[model.parents[j]], -j)))
        left.remove(order[-1])
    if order != sorted(order):
        described.model, where = _reordered(model, order)
        for shapes in (described.collision, described.visual):
            for shape in shapes.geometryObjects:
                shape.parentJoint = where[shape.parentJoint]


def _reordered(model: pin.Model, order: Sequence[int]) -> tuple[pin.Model, dict[int, int]]:
    """Return the same model with its joints in another order, and where each of them went."""
    new, where = pin.Model(), {0: 0}
    new.name, new.gravity = model.name, model.gravity
    new.inertias[0] = model.inertias[0]
    for joint in order:
        one = model.joints[joint]
        v, q = slice(one.idx_v, one.idx_v + one.nv), slice(one.idx_q, one.idx_q + one.nq)
        where[joint] = new.addJoint(
            where[model.parents[joint]], one, model.jointPlacements[joint], model.names[joint],
            np.array(model.upperEffortLimit[v]), np.array(model.upperVelocityLimit[v]),
            np.array(model.lowerPositionLimit[q]), np.array(model.upperPositionLimit[q]),
        )  # fmt: skip
        new.inertias[where[joint]] = model.inertias[joint]
        at = new.joints[where[joint]].idx_v
        for key in KEPT:
            getattr(new, key)[at : at + one.nv] = getattr(model, key)[v]
    for frame in list(model.frames)[1:]:
        new.addFrame(
            pin.Frame(
                frame.name, where[frame.parentJoint], frame.parentFrame, frame.placement,
                frame.type, frame.inertia,
            ),
            False,
        )  # fmt: skip
    return new, where
