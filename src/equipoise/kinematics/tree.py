"""A robot's tree of joints as kernels read it: constants, laid out once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.compiled import inlined
from equipoise.compiled.workspace import Arrays, Block, Part, Shape, integers
from equipoise.kinematics.followers import MIMIC, axes_of, followers_of, moved_by
from equipoise.spatial import pose_row

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
     "chain_first", "chain_count", "chain", "frame_joint", "inertia", "chain_column",
     "first_column", "width", "follows", "law", "summed", "above"),
    frozenset({"parent", "kind", "first_q", "first_v", "chain_first", "chain_count", "chain",
               "frame_joint", "chain_column", "first_column", "width", "follows", "summed",
               "above"}),
)  # fmt: skip
(PLACE, AXIS, MASS, BELOW, FRAME_PLACE, PARENT, KIND, FIRST_Q, FIRST_V, CHAIN_FIRST, CHAIN_COUNT,
 CHAIN, FRAME_JOINT, INERTIA, CHAIN_COLUMN, FIRST_COLUMN, WIDTH, FOLLOWS, LAW, SUMMED,
 ABOVE) = range(len(TREE.names))  # fmt: skip


def tree_shapes(joints: int, links: int, frames: int) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of a tree of `joints`, with `links` entries in all chains, and `frames`.

    `place` [joints, 12] is a joint in its parent, `axis` [joints, 3] its axis in itself, `mass`
    [joints, 4] mass and centre of what it moves, `inertia` [joints, 9] its inertia about that
    centre, in its axes, `below` [joints] the mass of all that it moves with. The velocities that
    move joint j are `chain[chain_first[j] : chain_first[j] + chain_count[j]]`, and what a unit of
    them does to it are the columns of these numbers in `chain_column`.

    What a joint adds by itself are `width` columns from `first_column` on, of the velocities from
    `first_v` on: the same numbers, but for joints that follow another one. `follows` is 1 for
    these, `law` [joints, 2] their ratio and offset. Where the joints before it move by the same
    velocity, by column `above`, both together are column `summed`, else -1.
    """
    return TREE.shapes(
        place=(joints, 12), axis=(joints, 3), mass=(joints, 4), below=joints,
        frame_place=(max(frames, 1), 12), parent=joints, kind=joints, first_q=joints,
        first_v=joints, chain_first=joints, chain_count=joints, chain=links,
        frame_joint=max(frames, 1), inertia=(joints, 9), chain_column=links, first_column=joints,
        width=joints, follows=joints, law=(joints, 2), summed=joints, above=joints,
    )  # fmt: skip


def tree_of(model: pin.Model, frames: Sequence[int]) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of a model's tree with these frames (ids)."""
    links = sum(len(moved_by(model, joint)) for joint in range(model.njoints))
    return tree_shapes(model.njoints, links, len(frames))


def fill_tree(part: Part, model: pin.Model, frames: Sequence[int]) -> None:
    """Write the constants of a robot's tree."""
    part.parent[:] = list(model.parents)
    axes = axes_of(model)
    turning = np.abs(axes[:, 3:]).max(axis=1) > 0.0
    part.axis[:] = np.where(turning[:, None], axes[:, 3:], axes[:, :3])
    for joint in range(1, model.njoints):
        one, inertia = model.joints[joint], model.inertias[joint]
        part.place[joint] = pose_row(model.jointPlacements[joint])
        part.kind[joint] = _kind_of(one.shortname(), turning=turning[joint])
        part.mass[joint, 0], part.mass[joint, 1:] = inertia.mass, inertia.lever
        part.inertia[joint] = inertia.inertia.ravel()
        part.first_q[joint], part.first_v[joint] = one.idx_q, one.idx_v
    part.below[:] = part.mass[:, 0]
    for joint in range(model.njoints - 1, 0, -1):
        part.below[part.parent[joint]] += part.below[joint]
    _fill_chains(part, model)
    fill_frames(part, model, frames)


def columns_in(model: pin.Model) -> int:
    """Return how many columns the joints of a model have: see `tree_shapes`."""
    return _columns_of(model).count


class _Columns:
    """Where the columns of each joint are, and by which ones its body moves."""

    def __init__(self, joints: int, nv: int) -> None:
        self.first, self.summed, self.above = [0] * joints, [-1] * joints, [-1] * joints
        self.moves: list[dict[int, int]] = [{} for _ in range(joints)]  # velocity -> column
        self.count = nv


def _columns_of(model: pin.Model) -> _Columns:
    found, following = _Columns(model.njoints, model.nv), {f.joint for f in followers_of(model)}
    for joint in range(1, model.njoints):
        one, moves = model.joints[joint], dict(found.moves[model.parents[joint]])
        found.moves[joint] = moves
        if joint not in following:
            found.first[joint] = one.idx_v
            moves.update((c, c) for c in range(one.idx_v, one.idx_v + one.nv))
            continue
        found.first[joint] = found.count
        found.count += 1
        if one.idx_v in moves:
            found.above[joint], found.summed[joint] = moves[one.idx_v], found.count
            moves[one.idx_v] = found.count
            found.count += 1
        else:
            moves[one.idx_v] = found.first[joint]
    return found


def _fill_chains(part: Part, model: pin.Model) -> None:
    columns, start = _columns_of(model), 0
    for joint in range(model.njoints):
        moves = columns.moves[joint]
        here = slice(start, start + len(moves))
        part.chain[here], part.chain_column[here] = list(moves), list(moves.values())
        part.chain_first[joint], part.chain_count[joint] = start, len(moves)
        start += len(moves)
        part.width[joint] = max(model.joints[joint].nv, 1) if joint else 0
    part.first_column[:], part.summed[:] = columns.first, columns.summed
    part.above[:] = columns.above
    for one in followers_of(model):
        part.follows[one.joint], part.law[one.joint] = 1, (one.ratio, one.offset)


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
    kinds = [_kind_of(joint.shortname(), turning=True) for joint in list(model.joints)[1:]]
    bases = [kind in (FREE, PLANAR) for kind in kinds]
    return OTHER not in kinds and not any(bases[1:])


def _kind_of(name: str, *, turning: bool) -> int:
    if name == MIMIC:
        return REVOLUTE if turning else PRISMATIC
    return _KINDS.get(name, OTHER)
