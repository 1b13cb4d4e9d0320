"""The law laid out in a workspace: which contacts there are, which hold, with which gains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from equipoise.compiled.workspace import Shape, Workspace
from equipoise.contacts import Contact, ContactStack
from equipoise.contacts.program import ContactProgram
from equipoise.control.base_wrench.bounded import BoundsProgram, carriers_of
from equipoise.control.base_wrench.foot_bounds import ReactionBounds, bounds_of, require_feet
from equipoise.control.base_wrench.observer import observer_gain
from equipoise.control.base_wrench.support import Support
from equipoise.control.passivity.gains import ControlGains
from equipoise.control.passivity.memory import (
    BOUNDED,
    BY_MEASURE,
    BY_ZMP,
    GAIN_COUNT,
    KEPT,
    REGULATED_COUNT,
    ROW_COUNT,
    SPLIT,
    SUPPORT_COUNT,
    SUPPORTING_COUNT,
    LawSizes,
    law_shapes,
)
from equipoise.control.passivity.nearest import unroot_of
from equipoise.errors import InputError
from equipoise.hqp.solvers.active_set.memory import SEARCH_MEMORY
from equipoise.kinematics.kernels import state_of
from equipoise.robots import Robot
from equipoise.spatial import Array

LoadSplit = Literal["measured", "zmp"]
_SPLITS: dict[str, int] = {"measured": BY_MEASURE, "zmp": BY_ZMP}
# the law's parts of a workspace, in this order; the tree is part 0
PARTS = ("measured", "law_contacts", "law", *BoundsProgram.names)


class LawProgram:
    """The law of a robot with all contacts that may ever hold."""

    def __init__(
        self,
        robot: Robot,
        contacts: Sequence[Contact],
        bounds: ReactionBounds | None,
        split: LoadSplit = "measured",
    ) -> None:
        self.robot, self.split = robot, split_code(split)
        self.contacts = ContactProgram(contacts)
        supporting = [c for c in contacts if c.supporting]
        unknowns = sum(c.size for c in supporting)
        rows = 0
        if bounds is not None:
            rows = sum(len(bounds_of(sole, bounds).b) for sole in require_feet(supporting))
        self.bounds = BoundsProgram(bounds or ReactionBounds(), unknowns, rows, robot.na)
        self.bounded = bounds is not None
        self.sizes = LawSizes(
            robot.nq, robot.nv, robot.na, len(contacts), self.contacts.size,
            sum(len(c.regulated) for c in contacts), unknowns, len(supporting),
        )  # fmt: skip

    def shapes(self, frames: int) -> dict[str, list[tuple[str, Shape, bool]]]:
        """Return the arrays of the law's parts, for a tree with a number of frames."""
        robot = self.robot
        return {
            "measured": state_of(robot.model, frames),
            "law_contacts": self.contacts.shapes(),
            "law": law_shapes(self.sizes),
            **self.bounds.shapes(),
        }

    @property
    def memory(self) -> tuple[str, ...]:
        """What is kept from tick to tick."""
        return (
            *(f"law.{name}" for name in KEPT),
            "law_contacts.on",
            "bounds.near_since",
            *(f"bound_search.{name}" for name in SEARCH_MEMORY),
        )

    def fill(self, workspace: Workspace, number_of: Callable[[str | int], int]) -> None:
        """Write the constants; `number_of` a frame is its number in the tree."""
        self.contacts.fill(workspace.parts["law_contacts"], number_of)
        workspace.parts["law"].tau_max[:] = self.robot.tau_max

    def tune(
        self, workspace: Workspace, gains: ControlGains, dt: float, filter_time: float
    ) -> None:
        """Write the gains."""
        law = workspace.parts["law"]
        law.K_d[:] = gains.damping_matrix(self.robot.nv)
        law.unroot[:] = unroot_of(law.K_d)
        law.gains[:] = gain_numbers(gains, dt, filter_time)

    def hold(self, workspace: Workspace, stack: ContactStack) -> None:
        """Let the contacts of a stack hold, and no others."""
        part, law = workspace.parts["law_contacts"], workspace.parts["law"]
        part.on[:] = 0
        for contact in stack.contacts:
            k = index_of(self.contacts.contacts, contact)
            part.on[k], law.at[k] = 1, stack.rows[contact.name].start
        support = Support(stack)
        law.J[:] = 0.0
        for name, values, count in (
            ("regulated", stack.regulated_rows, REGULATED_COUNT),
            ("supporting", stack.supporting_rows, SUPPORTING_COUNT),
            ("normal_rows", support.normal_rows, SUPPORT_COUNT),
            ("ends", support.ends, SUPPORT_COUNT),
        ):
            getattr(law, name)[: len(values)] = values
            law.flags[count] = len(values)
        law.flags[ROW_COUNT], law.flags[BOUNDED] = stack.size, self.bounded
        law.flags[SPLIT] = self.split
        law.centres.ravel()[: support.centres.size] = support.centres.ravel()
        law.terms.ravel()[: support.terms.size] = support.terms.ravel()
        if self.bounded:
            carriers = carriers_of(self.robot, support.contacts)
            self.bounds.fill(workspace, support.contacts, self.robot.nv_base, carriers)


def index_of(contacts: Sequence[Contact], wanted: Contact) -> int:
    """Return where a contact stands among others, -1 if it is not there."""
    return next((k for k, contact in enumerate(contacts) if contact is wanted), -1)


def gain_numbers(gains: ControlGains, dt: float, filter_time: float) -> Array:
    """Return the gains as the kernels read them."""
    numbers = np.array(
        [
            gains.alpha, gains.beta_p, gains.k_ip, gains.integral_max, gains.sgn_p.code,
            gains.sgn_p.layer, gains.beta_F, gains.k_iF, gains.sgn_F.code, gains.sgn_F.layer,
            gains.beta, gains.mu, gains.eta, gains.handover, gains.damp_violation, dt,
            observer_gain(filter_time, dt), gains.projector == "damping", gains.relax,
            gains.root, gains.adapt, gains.growth_max,
        ],
        dtype=float,
    )  # fmt: skip
    assert len(numbers) == GAIN_COUNT
    return numbers


def split_code(split: str) -> int:
    """Return how the load is split, as the kernels know it. Raises: `InputError`."""
    if split not in _SPLITS:
        raise InputError("no such split of the load", given=split, known=list(_SPLITS))
    return _SPLITS[split]
