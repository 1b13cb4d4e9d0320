"""The contacts of a tick, and the one place that calls their kernels.

A new kind of contact is its file and a line in `rows_of` and in `drift_of`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from equipoise.compiled import compiled
from equipoise.compiled.workspace import Arrays, Block, Part, Shape, integers, matrix, vector
from equipoise.contacts.base import Contact, KernelContact
from equipoise.contacts.grasp import grasp_drift, grasp_rows
from equipoise.contacts.moving import MovingSurfaceContact, StraightMotion, straight_place
from equipoise.contacts.point import point_drift, point_rows
from equipoise.contacts.sliding import SlidingContact, sliding_drift, sliding_rows
from equipoise.contacts.sole import sole_drift, sole_rows
from equipoise.contacts.surfaces.sample import OWN, SAMPLE
from equipoise.contacts.view import GRASP, NUMBERS, POINT, SLIDING, SOLE, ContactView
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array

CONTACTS = Arrays(
    ("numbers", "place", "motion", "sample", "residual", "rate", "drift", "kind", "first",
     "second", "surface", "moves", "on", "own", "size"),
    frozenset({"kind", "first", "second", "surface", "moves", "on", "own", "size"}),
)  # fmt: skip
(NUMBERS_OF, PLACE, MOTION, SAMPLES, RESIDUAL, RATE, DRIFT, KIND, FIRST, SECOND, SURFACE, MOVES, ON,
 OWN_ROW, SIZE) = range(len(CONTACTS.names))  # fmt: skip
STRAIGHT = 18  # numbers of a straight motion
PLACE_SIZE = 24


class ContactProgram:
    """Contacts with a fixed place each among the rows, whether they hold or not.

    Contact i has the rows `own[i] : own[i] + size[i]` of residual, rate and drift; where its rows
    of J begin is up to who asks for them. `on[i]` is 1 while it holds.
    """

    def __init__(self, contacts: Sequence[Contact]) -> None:
        self.contacts = tuple(contacts)
        self.starts = [0, *np.cumsum([c.size for c in contacts], dtype=int).tolist()]
        self.size = self.starts[-1]
        kernel = [(k, c) for k, c in enumerate(contacts) if isinstance(c, KernelContact)]
        self.plain = [(k, c) for k, c in enumerate(contacts) if not isinstance(c, KernelContact)]
        self.sampled = [
            (k, c) for k, c in kernel if isinstance(c, SlidingContact) and c.surface_kind == OWN
        ]
        self.placed = [
            (k, c) for k, c in kernel if _moves(c) and _straight(c) is None
        ]  # asked from Python where they are

    @property
    def needs_python(self) -> bool:
        """Whether Python has to look at the state before the rows can be made."""
        return bool(self.plain or self.sampled)

    def frames(self) -> list[str | int]:
        """Return the frames that the kernels need, some perhaps more than once."""
        return [f for c in self.contacts if isinstance(c, KernelContact) for f in c.frames]

    def shapes(self) -> list[tuple[str, Shape, bool]]:
        """Return the arrays of the contacts."""
        count, rows = max(len(self.contacts), 1), max(self.size, 1)
        return CONTACTS.shapes(
            numbers=(count, NUMBERS), place=(count, PLACE_SIZE), motion=(count, STRAIGHT),
            sample=(count, SAMPLE), residual=rows, rate=rows, drift=rows, kind=count, first=count,
            second=count, surface=count, moves=count, on=count, own=count, size=count,
        )  # fmt: skip

    def fill(self, part: Part, number_of: Callable[[str | int], int]) -> None:
        """Write the constants; `number_of` a frame is its number in the tree. All hold at first."""
        for k, contact in enumerate(self.contacts):
            part.on[k], part.own[k], part.size[k] = 1, self.starts[k], contact.size
            part.kind[k] = contact.kind
            if not isinstance(contact, KernelContact):
                continue
            part.first[k], part.second[k] = map(number_of, contact.frames)
            part.numbers[k, : len(contact.numbers)] = contact.numbers
            part.surface[k] = contact.surface_kind
            part.place[k] = contact.place(0.0)
            straight = _straight(contact)
            if straight is not None:
                part.moves[k], part.motion[k] = 1, straight

    def replace(self, part: Part, contact: Contact) -> None:
        """Let a contact take the place of the one of its name, which differs in its numbers alone.

        Nothing happens if there is none of the name.
        """
        known = list(self.contacts)
        for k, one in enumerate(known):
            if one.name == contact.name and isinstance(contact, KernelContact):
                known[k] = contact
                part.numbers[k, : len(contact.numbers)] = contact.numbers
        self.contacts = tuple(known)

    def write_places(self, part: Part, t: float) -> None:
        """Ask from Python where surfaces are at time `t` [s] that move by a rule of their own."""
        for k, contact in self.placed:
            part.place[k] = contact.place(t)

    def write_plain(
        self, part: Part, kin: Kinematics, J: Array, at: Sequence[int] | NDArray[np.integer]
    ) -> None:
        """Write the rows of contacts in plain Python, and the samples of surfaces of one's own.

        Row i of contact k goes to `J[at[k] + i]`. Those that do not hold are left out.
        """
        for k, sliding in self.sampled:
            if part.on[k]:
                part.sample[k] = sliding.sample(kin)
        for k, contact in self.plain:
            if part.on[k]:
                own = slice(self.starts[k], self.starts[k + 1])
                J[at[k] : at[k] + contact.size] = contact.jacobian(kin)
                part.residual[own], part.rate[own] = contact.residual(kin), contact.rate(kin)

    def write_plain_drifts(self, part: Part, kin: Kinematics) -> None:
        """Write the drifts of contacts in plain Python."""
        for k, contact in self.plain:
            if part.on[k]:
                part.drift[self.starts[k] : self.starts[k + 1]] = contact.drift(kin)


def _moves(contact: Contact) -> bool:
    return isinstance(contact, MovingSurfaceContact)


def _straight(contact: Contact) -> Array | None:
    """Return the numbers of a contact's straight motion, None if it has none."""
    if isinstance(contact, MovingSurfaceContact) and isinstance(contact.motion, StraightMotion):
        return contact.motion.numbers
    return None


@compiled
def move_surfaces(contacts: Block, t: float) -> None:
    """Write where the surfaces are that move along a line, at time t."""
    place, motion, moves = (
        matrix(contacts, PLACE),
        matrix(contacts, MOTION),
        integers(contacts, MOVES),
    )
    for k in range(moves.shape[0]):
        if moves[k]:
            straight_place(motion[k], t, place[k])


@compiled
def contact_rows(tree: Block, state: Block, contacts: Block, J: np.ndarray, at: np.ndarray) -> None:
    """Write J, residual and rate of every contact that holds; those of J from row at[k] on."""
    on = integers(contacts, ON)
    for k in range(on.shape[0]):
        if on[k]:
            rows_of(view_of(tree, state, contacts, k, J, at[k]), integers(contacts, KIND)[k])


@compiled
def contact_drifts(tree: Block, state: Block, contacts: Block, J: np.ndarray) -> None:
    """Write the drift of every contact that holds; the state must have velocities."""
    on = integers(contacts, ON)
    for k in range(on.shape[0]):
        if on[k]:
            drift_of(view_of(tree, state, contacts, k, J, 0), integers(contacts, KIND)[k])


@compiled
def view_of(
    tree: Block, state: Block, contacts: Block, k: int, J: np.ndarray, at: int
) -> ContactView:
    """Return contact k as its kernels see it."""
    return ContactView(
        tree, state, integers(contacts, FIRST)[k], integers(contacts, SECOND)[k],
        matrix(contacts, NUMBERS_OF)[k], matrix(contacts, PLACE)[k], matrix(contacts, SAMPLES)[k],
        integers(contacts, SURFACE)[k], J, at, vector(contacts, RESIDUAL), vector(contacts, RATE),
        vector(contacts, DRIFT), integers(contacts, OWN_ROW)[k],
    )  # fmt: skip


@compiled
def rows_of(view: ContactView, kind: int) -> None:
    """Write the rows of one contact; those of a GIVEN one stand there already."""
    if kind == SOLE:
        sole_rows(view)
    elif kind == GRASP:
        grasp_rows(view)
    elif kind == POINT:
        point_rows(view)
    elif kind == SLIDING:
        sliding_rows(view)


@compiled
def drift_of(view: ContactView, kind: int) -> None:
    """Write the drift of one contact; that of a GIVEN one stands there already."""
    if kind == SOLE:
        sole_drift(view)
    elif kind == GRASP:
        grasp_drift(view)
    elif kind == POINT:
        point_drift(view)
    elif kind == SLIDING:
        sliding_drift(view)
