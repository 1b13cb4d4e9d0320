"""A walk of a robot that is elsewhere: its soles tell their wrenches in the axes that they know."""

from __future__ import annotations

import pinocchio as pin

from equipoise.contacts import ContactStack, SoleContact
from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.estimation import EstimatingRobot
from equipoise.remote.ramp_out import Rest
from equipoise.simulation.build.assemble import Controls
from equipoise.simulation.build.leaning import build_leaning
from equipoise.simulation.walk import WalkDriver
from equipoise.spatial import Array
from equipoise.wire.interface import RobotInterface


class FarSoles:
    """What a walk tells of its feet, for a robot that is not told.

    The robot tells the wrench of a sole in the axes of where the sole stood at first; the law wants
    it in those of where it stands now. What holds is for the floor to say, as in an engine.
    """

    def __init__(self, contacts: ContactStack) -> None:
        self._contacts = contacts
        self._first = {
            one.name: one.T_world_anchor.rotation
            for one in contacts.contacts
            if isinstance(one, SoleContact)
        }
        self._turns: dict[str, Array] = {}  # from the first axes to those of now

    def support(self, name: str, T_world_anchor: pin.SE3 | None) -> None:
        """Want a sole's wrench in the axes of another place from now on; None: it is in the air.

        Raises: `NameNotFoundError`.
        """
        if name not in self._first:
            raise NameNotFoundError("sole contact", name, self._first)
        if T_world_anchor is not None:
            self._turns[name] = T_world_anchor.rotation.T @ self._first[name]

    def seen(self, lam: Array) -> Array:
        """Return the multipliers (r,) of all contacts in the axes of now."""
        lam = lam.copy()
        for name, turn in self._turns.items():
            first = self._contacts.rows[name].start
            for at in (first, first + 3):
                lam[at : at + 3] = turn @ lam[at : at + 3]
        return lam


def walk_of(controls: Controls, soles: FarSoles, link: RobotInterface) -> WalkDriver | None:
    """Return what leads the walk of a run, None where it stands.

    Raises: `ScenarioError` for a robot whose base is estimated; it is let go.
    """
    walk = controls.walk
    if walk is None:
        return None
    if isinstance(link, EstimatingRobot):
        link.close()
        raise ScenarioError(
            "the base of this robot is estimated from feet that stand, so it cannot walk yet",
            path="walk",
            remedy="Use a wire on which base and contact forces are measured: --wire udp",
        )
    leaning = build_leaning(controls.scenario, controls.setup, controls.levels, walk)
    setup = controls.setup
    return WalkDriver(walk, setup.robot, setup.contacts, controls.controller, soles, leaning)


def come_to_feet(walk: WalkDriver) -> Rest:
    """Return what lets a walk put its feet side by side, and tells whether it stands."""
    asked = False

    def stands() -> bool:
        nonlocal asked
        if not asked:
            walk.stop()
            asked = True
        return walk.walker.stands

    return stands
