"""A robot's tree of joints as kernels read it: constants, laid out once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.compiled import inlined
from equipoise.compiled.workspace import Arrays, Block, Part, Shape, integers
from equipoise.spatial import Array, pose_row

# kinds of joints; what none of these is (a spherical joint, say) is left to Pinocchio
REVOLUTE, CONTINUOUS, PRISMATIC, FREE, PLANAR, OTHER = range(6)
_KINDS = {
    "JointModelFreeFlyer": FREE,
    "JointModelPlanar": PLANAR,
    **{f"JointModelR{axis}": REVOLUTE for axis in ("X", "Y", "Z", "evoluteUnaligned")},
    **{f"JointModelRUB{axis}": CONTINUOUS for axis in "XYZ"},
    "JointModelRevoluteUnboundedUnaligned": CONTINUOUS,
    **{f"JointModelP{axis}": PRISMATIC for axis in ("X", "Y", "Z", "rismaticUnaligned")},
}

TREE = Arrays(
    ("place", "axis", "mass", "below", "frame_place", "parent", "kind", "first_q", "first_v",
     "chain_first", "chain_count", "chain", "frame_joint", "inertia"),
    frozenset({"parent", "kind", "first_q", "first_v", "chain_first", "chain_count", "chain",
               "frame_joint"}),
)  # fmt: skip
(PLACE, AXIS, MASS, BELOW, FRAME_PLACE, PARENT, KIND, FIRST_Q, FIRST_V, CHAIN_FIRST, CHAIN_COUNT,
 CHAIN, FRAME_JOINT, INERTIA) = range(len(TREE.names))  # fmt: skip


def tree_shapes(joints: int, links: int, frames: int) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of a tree of `joints`, with `links` columns in all chains, and `frames`.

    `place` [joints, 12] is a joint in its parent, `axis` [joints, 3] its axis in itself, `mass`
    [joints, 4] mass and centre of what it moves, `inertia` [joints, 9] its inertia about that
    centre, in its axes, `below` [joints] the mass of all that it moves with. The columns of the
    velocity that move joint j are `chain[chain_first[j] : chain_first[j] + chain_count[j]]`.
    """
    return TREE.shapes(
        place=(joints, 12), axis=(joints, 3), mass=(joints, 4), below=joints,
        frame_place=(max(frames, 1), 12), parent=joints, kind=joints, first_q=joints,
        first_v=joints, chain_first=joints, chain_count=joints, chain=links,
        frame_joint=max(frames, 1), inertia=(joints, 9),
    )  # fmt: skip


def tree_of(model: pin.Model, frames: Sequence[int]) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of a model's tree with these frames (ids)."""
    links = sum(len(_columns_of(model, joint)) for joint in range(model.njoints))
    return tree_shapes(model.njoints, links, len(frames))


def fill_tree(part: Part, model: pin.Model, frames: Sequence[int]) -> None:
    """Write the constants of a robot's tree."""
    part.parent[:] = list(model.parents)
    part.axis[:] = _axes_of(model)
    for joint in range(1, model.njoints):
        one, inertia = model.joints[joint], model.inertias[joint]
        part.place[joint] = pose_row(model.jointPlacements[joint])
        part.kind[joint] = _KINDS.get(one.shortname(), OTHER)
        part.mass[joint, 0], part.mass[joint, 1:] = inertia.mass, inertia.lever
        part.inertia[joint] = inertia.inertia.ravel()
        part.first_q[joint], part.first_v[joint] = one.idx_q, one.idx_v
    part.below[:] = part.mass[:, 0]
    for joint in range(model.njoints - 1, 0, -1):
        part.below[part.parent[joint]] += part.below[joint]
    start = 0
    for joint in range(model.njoints):
        columns = _columns_of(model, joint)
        part.chain[start : start + len(columns)] = columns
        part.chain_first[joint], part.chain_count[joint] = start, len(columns)
        start += len(columns)
    fill_frames(part, model, frames)


def fill_frames(part: Part, model: pin.Model, frames: Sequence[int]) -> None:
    """Write which frames (ids) the tree has."""
    for k, frame_id in enumerate(frames):
        frame = model.frames[frame_id]
        part.frame_joint[k] = frame.parentJoint
        part.frame_place[k] = pose_row(frame.placement)


@inlined
def base_size(tree: Block) -> int:
    """Return how many entries of a velocity belong to the base: 6, 3 or none."""
    kind = integers(tree, KIND)
    if kind.shape[0] > 1 and kind[1] == FREE:
        return 6
    return 3 if kind.shape[0] > 1 and kind[1] == PLANAR else 0


def has_kernels(model: pin.Model) -> bool:
    """Tell whether every joint is of a kind that the kernels know."""
    kinds = [_KINDS.get(joint.shortname(), OTHER) for joint in list(model.joints)[1:]]
    bases = [kind in (FREE, PLANAR) for kind in kinds]
    return OTHER not in kinds and not any(bases[1:])


def _axes_of(model: pin.Model) -> Array:
    """Return the axis (njoints, 3) of each joint of one degree of freedom in its own axes."""
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    axes = np.zeros((model.njoints, 3))
    for joint in range(1, model.njoints):
        one = model.joints[joint]
        if one.nv == 1:
            J = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL)[:, one.idx_v]
            axes[joint] = J[3:] if np.abs(J[3:]).max() > 0.5 else J[:3]
    return axes


def _columns_of(model: pin.Model, joint: int) -> list[int]:
    """Return the columns of the velocity that move a joint's body, from the base on."""
    supports = [model.joints[j] for j in list(model.supports[joint])[1:]]
    return [c for one in supports for c in range(one.idx_v, one.idx_v + one.nv)]
