"""Pairs of bodies of a tick: their shapes laid out, and the kernels that find distances and rates.

Where the cores of two shapes touch or pass into one another there is no direction between closest
points; such a pair of shapes is left to Coal (`ASK`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import coal
import numpy as np

from equipoise.collision.closest import closest_by_simplices, segment_to_box, segment_to_segment
from equipoise.collision.scene import Pair, Scene
from equipoise.collision.shapes import BOX, SEGMENT, core_of
from equipoise.compiled import Stage, compiled, scratch
from equipoise.compiled.workspace import Arrays, Block, Part, Shape, integers, matrix, vector
from equipoise.kinematics.kernels import COLUMNS, JOINTS
from equipoise.kinematics.tree import CHAIN, CHAIN_COLUMN, CHAIN_COUNT, CHAIN_FIRST
from equipoise.spatial import pose_row
from equipoise.spatial.kernels import compose, crossed, turned, turned_back

PAIRS = Arrays(
    ("place", "size", "radius", "centre", "reach", "points", "poses", "found", "distance",
     "limits", "joint", "core", "first_point", "first", "second", "pair_of", "end", "whole",
     "nearest", "state", "asked"),
    frozenset({"joint", "core", "first_point", "first", "second", "pair_of", "end", "whole",
               "nearest", "state", "asked"}),
)  # fmt: skip
(PLACE, SIZE, RADIUS, CENTRE, REACH, POINTS, POSES, FOUND, DISTANCE, LIMITS, JOINT, CORE,
 FIRST_POINT, FIRST, SECOND, PAIR_OF, END, WHOLE, NEAREST, STATE,
 ASKED) = range(len(PAIRS.names))  # fmt: skip
# states of a pair of shapes: farther apart than anyone asks, known, to be asked of Coal
FAR, KNOWN, ASK = range(3)
# a row of `found`: distance, normal from first to second, closest point of the first, the second
NORMAL, ON_FIRST, ON_SECOND = 1, 4, 7
FOUND_SIZE = 10


class PairProgram:
    """The pairs of a scene whose distances are wanted, in pairs of shapes.

    Pairs of shapes come first, those of pair k together; after them, `ended`, come the round ends
    of capsules against the other shape: the closest point of a capsule jumps from one end to the
    other when it turns past parallel to a face, and with it the row of the pair. With a row for
    each end beside the row of the whole the set of allowed velocities stays continuous there.
    """

    def __init__(self, scene: Scene, pairs: Sequence[Pair], *, ends: bool = False) -> None:
        self.scene, self.pairs = scene, tuple(pairs)
        self.shapes = scene.geometry.geometryObjects
        self.cores = {
            i: core_of(self.shapes[i])
            for pair in self.pairs
            for body in (pair.first, pair.second)
            for i in scene.shapes_of(body)
        }
        self.numbers = {shape: k for k, shape in enumerate(self.cores)}
        self.couples = [
            (i, j, k)
            for k, pair in enumerate(self.pairs)
            for i in scene.shapes_of(pair.first)
            for j in scene.shapes_of(pair.second)
        ]  # shapes and the pair they belong to
        self.ended = [
            (n, which, sign)
            for n, (i, j, _) in enumerate(self.couples if ends else ())
            for which, shape in ((0, i), (1, j))
            if isinstance(self.shapes[shape].geometry, coal.Capsule)
            for sign in (-1, 1)
        ]  # pair of shapes, which of the two is the capsule, which end

    @property
    def count(self) -> int:
        """Number of pairs of shapes, and of ends against a shape."""
        return len(self.couples) + len(self.ended)

    def end_labels(self) -> tuple[str, ...]:
        """Return a name for each end."""
        labels = []
        for n, which, sign in self.ended:
            i, j, k = self.couples[n]
            ended, other = (i, j) if which == 0 else (j, i)
            number = (1 + sign) // 2
            labels.append(
                f"{self.pairs[k].name} ({self.shapes[ended].name} end {number}, "
                f"{self.shapes[other].name})"
            )
        return tuple(labels)

    def columns(self, chain_of: dict[int, list[int]], n: int) -> list[int]:
        """Return the columns of the velocity that a pair of shapes (or an end) depends on."""
        i, j, _ = self.couples[n if n < len(self.couples) else self.ended[n - len(self.couples)][0]]
        first, second = self.shapes[i].parentJoint, self.shapes[j].parentJoint
        return sorted({*chain_of[first], *chain_of[second]})

    def array_shapes(self) -> list[tuple[str, Shape, bool]]:
        """Return the arrays; `found` [n, 10] has a row a pair of shapes or end."""
        s, n, k = max(len(self.cores), 1), max(self.count, 1), max(len(self.pairs), 1)
        points = max(sum(len(core.points) for core in self.cores.values()), 1)
        return PAIRS.shapes(
            place=(s, 12), size=(s, 3), radius=s, centre=(s, 3), reach=s, points=(points, 3),
            poses=(s, 12), found=(n, FOUND_SIZE), distance=k, limits=2, joint=s, core=s,
            first_point=s + 1, first=n, second=n, pair_of=n, end=n, whole=n, nearest=k, state=n,
            asked=1,
        )  # fmt: skip

    def fill(self, part: Part, influence: float = np.inf, close: float = 0.0) -> None:
        """Write the constants: how near pairs are looked at, and pairs of shapes for their ends."""
        part.limits[:] = influence, close
        part.whole[:] = -1  # where there is no pair at all
        start = 0
        for shape, core in self.cores.items():
            k, one = self.numbers[shape], self.shapes[shape]
            part.place[k], part.joint[k] = pose_row(one.placement), one.parentJoint
            part.core[k], part.size[k], part.radius[k] = core.kind, core.size, core.radius
            part.centre[k], part.reach[k] = core.centre, core.reach
            part.points[start : start + len(core.points)] = core.points
            part.first_point[k], start = start, start + len(core.points)
            part.first_point[k + 1] = start
        for n in range(self.count):
            whole, which, sign = n, 0, 0
            if n >= len(self.couples):
                whole, which, sign = self.ended[n - len(self.couples)]
            i, j, pair = self.couples[whole]
            part.first[n], part.second[n], part.pair_of[n] = self.numbers[i], self.numbers[j], pair
            part.whole[n], part.end[n] = whole, sign * (1 + which)
        part.distance[:], part.state[:] = np.inf, FAR

    def ask_coal(self, part: Part) -> None:
        """Find out by Coal what the kernels left open."""
        request = coal.DistanceRequest()
        for n in np.flatnonzero(part.state == ASK).tolist():
            i, j = part.first[n], part.second[n]
            one, other = self._geometry(i, n, part, 0), self._geometry(j, n, part, 1)
            result = coal.DistanceResult()
            distance = coal.distance(*one, *other, request, result)
            part.found[n, 0] = distance
            part.found[n, NORMAL:ON_FIRST] = result.normal
            part.found[n, ON_FIRST:ON_SECOND] = result.getNearestPoint1()
            part.found[n, ON_SECOND:] = result.getNearestPoint2()
            part.state[n] = KNOWN
        part.asked[0] = 0

    def _geometry(
        self, number: int, n: int, part: Part, which: int
    ) -> tuple[coal.CollisionGeometry, coal.Transform3s]:
        """Return shape and place of one side of a pair of shapes, or of an end."""
        shape = next(s for s, k in self.numbers.items() if k == number)
        row, end = part.poses[number], part.end[n]
        geometry = self.shapes[shape].geometry
        R, p = row[:9].reshape(3, 3).T, row[9:].copy()
        if abs(end) == which + 1:
            p += np.sign(end) * part.size[number, 0] * R[:, 2]
            geometry = coal.Sphere(part.radius[number])
        return geometry, coal.Transform3s(R, p)


@compiled
def place_shapes(state: Block, pairs: Block) -> None:
    """Write where all shapes are."""
    joints, place, poses = matrix(state, JOINTS), matrix(pairs, PLACE), matrix(pairs, POSES)
    joint = integers(pairs, JOINT)
    for k in range(place.shape[0]):
        compose(joints[joint[k]], place[k], poses[k])


@compiled
def find_distances(state: Block, pairs: Block, number: int) -> int:
    """Find the distance of every pair within the first of `limits`; return what is left to Coal.

    A pair of shapes that is certainly farther apart is FAR. Ends are looked at where their pair of
    shapes is nearer than the second of `limits`.
    """
    influence, close = vector(pairs, LIMITS)[0], vector(pairs, LIMITS)[1]
    place_shapes(state, pairs)
    known, whole, asked = integers(pairs, STATE), integers(pairs, WHOLE), 0
    found = matrix(pairs, FOUND)
    for n in range(known.shape[0]):
        if whole[n] < 0:
            known[n] = FAR
        elif whole[n] == n:
            known[n] = FAR if bound_of(pairs, n) > influence else find_distance(pairs, n)
        elif known[whole[n]] == FAR:
            known[n] = FAR
        elif known[whole[n]] == ASK or found[whole[n], 0] < close:
            known[n] = find_distance(pairs, n)
        else:
            known[n] = FAR
        if known[n] == ASK:
            asked += 1
    integers(pairs, ASKED)[0] = asked
    return asked


FIND = Stage(1, find_distances)
find_distances_there = FIND.call


@compiled
def bound_of(pairs: Block, n: int) -> float:
    """Return a distance that two shapes certainly have, from balls around them; exact for a box."""
    i, j = integers(pairs, FIRST)[n], integers(pairs, SECOND)[n]
    core, reach, centre = integers(pairs, CORE), vector(pairs, REACH), matrix(pairs, CENTRE)
    A, B = matrix(pairs, POSES)[i], matrix(pairs, POSES)[j]
    ax, ay, az = turned(A, centre[i, 0], centre[i, 1], centre[i, 2])
    bx, by, bz = turned(B, centre[j, 0], centre[j, 1], centre[j, 2])
    ax, ay, az = ax + A[9], ay + A[10], az + A[11]
    bx, by, bz = bx + B[9], by + B[10], bz + B[11]
    x, y, z = ax - bx, ay - by, az - bz
    least = math.sqrt(x * x + y * y + z * z) - reach[i] - reach[j]
    size = matrix(pairs, SIZE)
    if core[j] == BOX:
        least = max(least, from_box(B, size[j], ax, ay, az) - reach[i])
    if core[i] == BOX:
        least = max(least, from_box(A, size[i], bx, by, bz) - reach[j])
    return least


@compiled
def from_box(B: np.ndarray, half: np.ndarray, x: float, y: float, z: float) -> float:
    """Return the distance of a point from a box at B, zero inside."""
    x, y, z = turned_back(B, x - B[9], y - B[10], z - B[11])
    x, y, z = max(abs(x) - half[0], 0.0), max(abs(y) - half[1], 0.0), max(abs(z) - half[2], 0.0)
    return math.sqrt(x * x + y * y + z * z)


@compiled
def find_distance(pairs: Block, n: int) -> int:
    """Write the row of a pair of shapes or of an end; return KNOWN, or ASK if Coal has to."""
    i, j, end = integers(pairs, FIRST)[n], integers(pairs, SECOND)[n], integers(pairs, END)[n]
    core, size, radius = integers(pairs, CORE), matrix(pairs, SIZE), vector(pairs, RADIUS)
    A, B = matrix(pairs, POSES)[i], matrix(pairs, POSES)[j]
    row, on_a, on_b = matrix(pairs, FOUND)[n], scratch(3), scratch(3)
    if abs(end) == 1:
        A = ended(A, size[i, 0], end, scratch(12))
    elif abs(end) == 2:
        B = ended(B, size[j, 0], end, scratch(12))
    long_a = 0.0 if abs(end) == 1 else size[i, 0]
    long_b = 0.0 if abs(end) == 2 else size[j, 0]
    apart = True
    if core[i] == SEGMENT and core[j] == SEGMENT:
        segment_to_segment(A, long_a, B, long_b, on_a, on_b)
    elif core[i] == SEGMENT and core[j] == BOX:
        segment_to_box(A, long_a, B, size[j], on_a, on_b)
    elif core[i] == BOX and core[j] == SEGMENT:
        segment_to_box(B, long_b, A, size[i], on_b, on_a)
    else:
        size_a, size_b = scratch(3), scratch(3)
        for c in range(3):
            size_a[c], size_b[c] = size[i, c], size[j, c]
        if core[i] == SEGMENT:
            size_a[0] = long_a
        if core[j] == SEGMENT:
            size_b[0] = long_b
        first, points = integers(pairs, FIRST_POINT), matrix(pairs, POINTS)
        apart = closest_by_simplices(
            core[i], size_a, points[first[i] : first[i + 1]], A,
            core[j], size_b, points[first[j] : first[j + 1]], B, on_a, on_b,
        )  # fmt: skip
    x, y, z = on_b[0] - on_a[0], on_b[1] - on_a[1], on_b[2] - on_a[2]
    length = math.sqrt(x * x + y * y + z * z)
    if not (apart and length > 1e-7):
        return ASK
    x, y, z = x / length, y / length, z / length
    row[0], row[1], row[2], row[3] = length - radius[i] - radius[j], x, y, z
    row[4], row[5], row[6] = (
        on_a[0] + radius[i] * x,
        on_a[1] + radius[i] * y,
        on_a[2] + radius[i] * z,
    )
    row[7], row[8], row[9] = (
        on_b[0] - radius[j] * x,
        on_b[1] - radius[j] * y,
        on_b[2] - radius[j] * z,
    )
    return KNOWN


@compiled
def ended(T: np.ndarray, length: float, end: int, out: np.ndarray) -> np.ndarray:
    """Write and return the pose row of an end of a segment along z of T."""
    along = length if end > 0 else -length
    for k in range(9):
        out[k] = T[k]
    for k in range(3):
        out[9 + k] = T[9 + k] + along * T[6 + k]
    return out


@compiled
def least_of_pairs(pairs: Block) -> None:
    """Write each pair's least distance over its shapes, infinite if FAR, and which that is."""
    known, whole, pair_of = integers(pairs, STATE), integers(pairs, WHOLE), integers(pairs, PAIR_OF)
    found, distance, nearest = (
        matrix(pairs, FOUND),
        vector(pairs, DISTANCE),
        integers(pairs, NEAREST),
    )
    for k in range(distance.shape[0]):
        distance[k], nearest[k] = np.inf, -1
    for n in range(known.shape[0]):
        k = pair_of[n]
        if whole[n] == n and known[n] == KNOWN and found[n, 0] < distance[k]:
            distance[k], nearest[k] = found[n, 0], n


@compiled
def distance_row(tree: Block, state: Block, pairs: Block, n: int, A: np.ndarray, at: int) -> None:
    """Write to A[at] the rate of a distance: the second point's speed minus the first's."""
    row = matrix(pairs, FOUND)[n]
    joint = integers(pairs, JOINT)
    first, second = joint[integers(pairs, FIRST)[n]], joint[integers(pairs, SECOND)[n]]
    columns, chain, by = matrix(state, COLUMNS), integers(tree, CHAIN), integers(tree, CHAIN_COLUMN)
    starts, counts = integers(tree, CHAIN_FIRST), integers(tree, CHAIN_COUNT)
    for k in range(starts[first], starts[first] + counts[first]):
        A[at, chain[k]] = 0.0
    for k in range(starts[second], starts[second] + counts[second]):
        A[at, chain[k]] = 0.0
    nx, ny, nz = row[1], row[2], row[3]
    mx, my, mz = crossed(row[7], row[8], row[9], nx, ny, nz)
    for k in range(starts[second], starts[second] + counts[second]):
        column = columns[by[k]]
        A[at, chain[k]] += (
            nx * column[0] + ny * column[1] + nz * column[2]
            + mx * column[3] + my * column[4] + mz * column[5]
        )  # fmt: skip
    mx, my, mz = crossed(row[4], row[5], row[6], nx, ny, nz)
    for k in range(starts[first], starts[first] + counts[first]):
        column = columns[by[k]]
        A[at, chain[k]] -= (
            nx * column[0] + ny * column[1] + nz * column[2]
            + mx * column[3] + my * column[4] + mz * column[5]
        )  # fmt: skip
