"""A tick written into a record by one kernel: the state, and what is computed for the log only."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from equipoise.collision.pairs import (
    DISTANCE,
    FIND,
    WHOLE,
    PairProgram,
    find_distances_there,
    least_of_pairs,
)
from equipoise.collision.scene import Pair, Scene
from equipoise.compiled import compiled, entrance
from equipoise.compiled.workspace import (
    Arrays,
    Block,
    Shape,
    Workspace,
    integer_matrix,
    integers,
    matrix,
    part_of,
    vector,
)
from equipoise.contacts import ContactStack, SoleContact, SupportPolygon, outline
from equipoise.contacts.support_polygon import least_room
from equipoise.contacts.wrench_cone import margins_of
from equipoise.kinematics.kernels import (
    COM,
    FRAMES,
    Q,
    place_frames,
    place_joints,
    state_of,
    weigh,
)
from equipoise.kinematics.manifold import difference
from equipoise.kinematics.tree import base_size, fill_tree, tree_of
from equipoise.runlog import TickRecord
from equipoise.spatial import Array
from equipoise.spatial.kernels import rotation_difference
from equipoise.tasks import FramePoseTask
from equipoise.trajectories.targets import ROWS, TargetList, evaluate_targets, write_given

SEEN = Arrays(
    ("error", "outline", "margin", "normals", "offsets", "edge", "frame", "target", "first_row",
     "of_state", "of_error", "of_margin", "of_lam", "lam_rows"),
    frozenset({"frame", "target", "first_row", "of_state", "of_error", "of_margin", "of_lam",
               "lam_rows"}),
)  # fmt: skip
(ERROR, OUTLINE, MARGIN, NORMALS, OFFSETS, EDGE, FRAME, TARGET, FIRST_ROW, OF_STATE, OF_ERROR,
 OF_MARGIN, OF_LAM, LAM_ROWS) = range(len(SEEN.names))  # fmt: skip
# what `of_state` tells the place of, in a record
STATE_CHANNELS = ("q", "v", "q_ref", "v_ref", "tau", "s", "dq", "com", "com_margin", "distance")
(OF_Q, OF_V, OF_Q_REF, OF_V_REF, OF_TAU, OF_S, OF_DQ, OF_COM, OF_EDGE,
 OF_DISTANCE) = range(len(STATE_CHANNELS))  # fmt: skip


@entrance
def observe(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, t: float, q: np.ndarray,
    v: np.ndarray, result: np.ndarray, lam: np.ndarray, numbers: np.ndarray,
) -> int:  # fmt: skip
    """Write a tick into a record's `numbers`; return how many distances Coal is asked for.

    `result` is that of the whole-body tick: q_ref, v_ref, tau, u, s. `frame` is negative behind the
    last task, `first_row` behind the last sole, `of_lam` behind the last contact.
    """
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1)
    targets, pairs = part_of(floats, whole, tables, 2), part_of(floats, whole, tables, 3)
    seen = part_of(floats, whole, tables, 4)
    own, at = vector(state, Q), integers(seen, OF_STATE)
    nq, nv = q.shape[0], v.shape[0]
    base = base_size(tree)
    write(q, own, 0)
    place_joints(tree, state)
    place_frames(tree, state)
    weigh(tree, state)
    write(q, numbers, at[OF_Q])
    write(v, numbers, at[OF_V])
    write(result[:nq], numbers, at[OF_Q_REF])
    write(result[nq : nq + nv], numbers, at[OF_V_REF])
    end = nq + nv + nv - base
    write(result[nq + nv : end], numbers, at[OF_TAU])
    write(result[end + nv : end + 2 * nv], numbers, at[OF_S])
    difference(tree, result[:nq], own, numbers[at[OF_DQ] : at[OF_DQ] + nv])
    com = vector(state, COM)
    write(com, numbers, at[OF_COM])
    numbers[at[OF_EDGE]] = least_room(matrix(seen, NORMALS), vector(seen, OFFSETS), com[0], com[1])
    evaluate_targets(targets, t)
    measure_errors(state, targets, seen, numbers)
    write_forces(seen, lam, numbers)
    asked = find_distances_there(state, pairs, 0)
    if asked == 0:
        write_distances(pairs, numbers, at[OF_DISTANCE])
    return asked


@entrance
def observe_forces(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, lam: np.ndarray, numbers: np.ndarray
) -> None:
    """Write multipliers lam [r] into a record's `numbers`, and what follows from them alone."""
    write_forces(part_of(floats, whole, tables, 4), lam, numbers)


@compiled
def write_forces(seen: Block, lam: np.ndarray, numbers: np.ndarray) -> None:
    """Write the multipliers of each contact and the margins of each sole."""
    measure_margins(seen, lam, numbers)
    places, rows = integers(seen, OF_LAM), integer_matrix(seen, LAM_ROWS)
    for k in range(places.shape[0]):
        if places[k] >= 0:
            write(lam[rows[k, 0] : rows[k, 1]], numbers, places[k])


@compiled
def write(x: np.ndarray, numbers: np.ndarray, at: int) -> None:
    """Copy x to numbers[at:]."""
    for i in range(x.shape[0]):
        numbers[at + i] = x[i]


@compiled
def write_distances(pairs: Block, numbers: np.ndarray, at: int) -> None:
    """Write the least distance of each pair."""
    least_of_pairs(pairs)
    if integers(pairs, WHOLE)[0] >= 0:  # there is a pair at all
        write(vector(pairs, DISTANCE), numbers, at)


@compiled
def measure_errors(state: Block, targets: Block, seen: Block, numbers: np.ndarray) -> None:
    """Write how far each frame is from its target: position [m], rotation vector [rad]."""
    frame, target, error = integers(seen, FRAME), integers(seen, TARGET), matrix(seen, ERROR)
    frames, rows = matrix(state, FRAMES), matrix(targets, ROWS)
    for k in range(frame.shape[0]):
        if frame[k] < 0:
            return
        T, wanted = frames[frame[k]], rows[target[k]]
        for i in range(3):
            error[k, i] = wanted[9 + i] - T[9 + i]
        error[k, 3], error[k, 4], error[k, 5] = rotation_difference(wanted, T)
        write(error[k], numbers, integers(seen, OF_ERROR)[k])


@compiled
def measure_margins(seen: Block, lam: np.ndarray, numbers: np.ndarray) -> None:
    """Write how far the reaction of each sole is from what a floor cannot give."""
    first, margin = integers(seen, FIRST_ROW), matrix(seen, MARGIN)
    for k in range(first.shape[0]):
        if first[k] < 0:
            return
        margin[k, 0], margin[k, 1], margin[k, 2], margin[k, 3] = margins_of(
            lam[first[k] : first[k] + 6], matrix(seen, OUTLINE)[k]
        )
        write(margin[k], numbers, integers(seen, OF_MARGIN)[k])


class Observer:
    """Writes a true state and its reference into a record, with what follows from them.

    Those are the channels `STATE_CHANNELS`, `error/TASK` of frame tasks, `margin/SOLE` and
    `lam/CONTACT`.
    """

    def __init__(
        self,
        scene: Scene,
        pairs: Sequence[Pair],
        tasks: Sequence[FramePoseTask],
        contacts: ContactStack,
        polygon: SupportPolygon | None,
    ) -> None:
        robot = scene.robot
        self.pairs, self.targets = PairProgram(scene, pairs), TargetList()
        numbers = [self.targets.number_of(task.target) for task in tasks]
        frames = list(dict.fromkeys(robot.frame_id(task.frame) for task in tasks))
        soles = [one for one in contacts.contacts if isinstance(one, SoleContact)]
        edges = 0 if polygon is None else 4 * len(contacts.contacts)  # each brings four at most
        self.workspace = Workspace(
            {
                "tree": tree_of(robot.model, frames),
                "state": state_of(robot.model, len(frames)),
                "targets": self.targets.shapes(),
                "pairs": self.pairs.array_shapes(),
                "seen": _seen_shapes(len(tasks), len(soles), len(contacts.contacts), edges),
            },
            stages=[FIND],
        )
        parts = self.workspace.parts
        fill_tree(parts["tree"], robot.model, frames)
        self.targets.fill(parts["targets"])
        self.pairs.fill(parts["pairs"])
        seen = parts["seen"]
        seen.offsets[:] = np.inf
        seen.frame[:], seen.first_row[:] = -1, -1
        for k, (task, number) in enumerate(zip(tasks, numbers, strict=True)):
            seen.frame[k], seen.target[k] = frames.index(robot.frame_id(task.frame)), number
        for k, contact in enumerate(soles):
            seen.first_row[k] = contacts.rows[contact.name].start
            seen.outline[k] = outline(contact.sole, contact.friction)
        self._tasks, self._soles, self._contacts = tasks, soles, contacts
        self._blocks = self.workspace.floats, self.workspace.integers, self.workspace.tables
        if polygon is not None:
            self.stand_on(polygon)

    def stand_on(self, polygon: SupportPolygon | None) -> None:
        """Measure the centre of mass against this polygon from now on; None: nothing holds it."""
        seen = self.workspace.parts["seen"]
        seen.normals[:], seen.offsets[:] = 0.0, np.inf
        if polygon is None:
            seen.offsets[:] = -np.inf
            return
        count = len(polygon.offsets)
        seen.normals[:count], seen.offsets[:count] = polygon.normals, polygon.offsets

    def write_into(self, record: TickRecord) -> None:
        """Write into this record from now on."""
        self._numbers, seen = record.numbers, self.workspace.parts["seen"]

        def starts(names: Iterable[str]) -> list[int]:
            return [record.places[name].start for name in names]

        seen.of_state[:] = starts(STATE_CHANNELS)
        seen.of_error[: len(self._tasks)] = starts(f"error/{task.name}" for task in self._tasks)
        seen.of_margin[: len(self._soles)] = starts(f"margin/{sole.name}" for sole in self._soles)
        seen.of_lam[:] = -1
        for k, (name, rows) in enumerate(self._contacts.rows.items()):
            seen.of_lam[k] = record.places[f"lam/{name}"].start
            seen.lam_rows[k] = rows.start, rows.stop

    def look(self, t: float, q: Array, v: Array, result: Array, lam: Array) -> None:
        """Write the tick of time `t` [s]: true `q` (nq,), `v` (nv,), what it gave, `lam` (r,)."""
        parts = self.workspace.parts
        if self.targets.given:
            write_given(parts["targets"], self.targets.given, t)
        if observe(*self._blocks, t, q, v, result, lam, self._numbers):
            self.pairs.ask_coal(parts["pairs"])
            distances_alone(*self._blocks, self._numbers)

    def look_at_forces(self, lam: Array) -> None:
        """Write `lam` (r,) and what follows from it into the tick that was written last."""
        observe_forces(*self._blocks, lam, self._numbers)


@entrance
def distances_alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, numbers: np.ndarray
) -> None:
    """Write the distances, after Coal was asked for some."""
    seen = part_of(floats, whole, tables, 4)
    at = integers(seen, OF_STATE)[OF_DISTANCE]
    write_distances(part_of(floats, whole, tables, 3), numbers, at)


def _seen_shapes(
    tasks: int, soles: int, contacts: int, edges: int
) -> list[tuple[str, Shape, bool]]:
    k, s, c, p = max(tasks, 1), max(soles, 1), max(contacts, 1), edges
    return SEEN.shapes(
        error=(k, 6), outline=(s, 5), margin=(s, 4), normals=(p, 2), offsets=p, edge=1, frame=k,
        target=k, first_row=s, of_state=len(STATE_CHANNELS), of_error=k, of_margin=s, of_lam=c,
        lam_rows=(c, 2),
    )  # fmt: skip
