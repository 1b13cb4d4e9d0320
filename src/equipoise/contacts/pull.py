"""Refusing to want that a contact pulls which can only push."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from equipoise.contacts.base import Contact
from equipoise.errors import InputError
from equipoise.spatial import Array


def least_wanted(contacts: Iterable[Contact]) -> dict[str, float]:
    """Return by "contact/row" the least multiplier that each regulated row may be told to have.

    Zero where the contact only pushes, minus infinity elsewhere.
    """
    return {
        f"{contact.name}/{row}": 0.0 if row in contact.one_sided else -float("inf")
        for contact in contacts
        for row in contact.regulated
    }


def least_regulated(contacts: Iterable[Contact]) -> Array:
    """Return the same for the regulated rows of contacts that hold (k,), in their order."""
    return np.array([*least_wanted(contacts).values()])


def refuse_pull(row: str, least: float, wanted: float, when: str = "") -> None:
    """Refuse a wanted multiplier below the least that is possible. Raises: `InputError`."""
    if wanted < least:
        raise InputError(
            f"{row} can only push, and it is wanted to pull{when}",
            given=float(wanted),
            remedy="Give a force that is not negative",
        )
