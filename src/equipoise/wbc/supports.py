"""Which contacts hold: those of the schedule that were not let go, where they stand now."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import pinocchio as pin

from equipoise.contacts import Contact, ContactSchedule, ContactStack, PointContact, SoleContact
from equipoise.errors import InputError, NameNotFoundError


class Supports:
    """Gives the stack of a time, the same object until something changes.

    `contacts` are all that ever hold, by name, as they stand now: a foot that lands elsewhere has
    another anchor than before, and is in `moved`. `free` are the names of those that were let go.
    """

    def __init__(self, schedule: ContactSchedule) -> None:
        self._schedule = schedule
        self.contacts: dict[str, Contact] = {c.name: c for c in schedule.contacts}
        self.moved: list[Contact] = []
        self.free: frozenset[str] = frozenset()
        self._stacks: dict[ContactStack, ContactStack] = {}

    def at(self, t: float) -> ContactStack:
        """Return the contacts that hold at time `t` [s]."""
        planned = self._schedule.at(t)
        if planned not in self._stacks:
            here = [self.contacts[name] for name in planned.rows if name not in self.free]
            same = len(here) == len(planned.contacts) and all(map(_is, here, planned.contacts))
            self._stacks[planned] = planned if same else ContactStack(here)
        return self._stacks[planned]

    def named(self, names: Iterable[str]) -> ContactStack:
        """Return the stack of the schedule's times that has these contacts, or a new one."""
        names = list(names)
        for stack in map(self.at, self._schedule.changes):
            if list(stack.rows) == names:
                return stack
        return ContactStack([self.contacts[name] for name in names])

    def names(self, *, supporting: bool) -> list[str]:
        """Return the names of all contacts that support, or of all others."""
        return [name for name, one in self.contacts.items() if one.supporting == supporting]

    def require(self, names: Iterable[str], *, supporting: bool) -> None:
        """Refuse names of which there is no contact of this sort.

        Raises: `NameNotFoundError`; `InputError` for what is no list of names.
        """
        known = self.names(supporting=supporting)
        what = "supporting contact" if supporting else "contact that does not support"
        if isinstance(names, str) or not isinstance(names, Iterable):
            raise InputError(f"name each {what} in a list", given=names, known=known)
        for name in names:
            if name not in known:
                raise NameNotFoundError(what, name, known)

    def let_go(self, names: Iterable[str]) -> None:
        """Let these go, and all others hold."""
        self.free = frozenset(names)
        self._stacks.clear()

    def anchor(self, name: str, T_world_anchor: pin.SE3) -> None:
        """Let a sole or a point stand elsewhere from now on.

        Raises: `NameNotFoundError`, `InputError` for what has no anchor.
        """
        if name not in self.contacts:
            raise NameNotFoundError("contact", name, self.contacts)
        old = self.contacts[name]
        if isinstance(old, SoleContact):
            self.contacts[name] = replace(old, T_world_anchor=T_world_anchor)
        elif isinstance(old, PointContact):
            self.contacts[name] = replace(old, p_world=T_world_anchor.translation.copy())
        else:
            raise InputError(
                f"contact {name!r} stands nowhere: only soles and points have an anchor",
                given=type(old).__name__,
            )
        self.moved = [one for one in self.moved if one.name != name] + [self.contacts[name]]
        self._stacks.clear()

    def state(self) -> dict[str, Any]:
        """Return what was changed: who is free, and every contact as it stands."""
        return {"free": self.free, "contacts": dict(self.contacts)}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state` returned."""
        before, self.contacts = self.contacts, dict(state["contacts"])
        stay = {one.name for one in self.moved}
        self.moved = [
            one for name, one in self.contacts.items() if name in stay or one is not before[name]
        ]
        self.let_go(state["free"])


def _is(a: Contact, b: Contact) -> bool:
    return a is b
