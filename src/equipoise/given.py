"""What is given from outside and is no number: its class, lists of names, things by name.

Numbers are checked by `equipoise.spatial.numbers`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from equipoise.errors import InputError


def require_kind(what: str, value: object, kind: type, remedy: str = "") -> None:
    """Refuse what is no `kind` where it is given, before it fails somewhere inside.

    Raises: `InputError`.
    """
    if not isinstance(value, kind):
        plain = value is None or isinstance(value, str | int | float)
        raise InputError(
            f"{what} must be a {kind.__name__}",
            given=repr(value) if plain else type(value).__name__,
            remedy=remedy,
        )


def names_of(what: str, given: object) -> tuple[str, ...]:
    """Return names as a tuple; a single name is no list. Raises: `InputError`."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InputError(f"{what} must be a list of names", given=given)
    names = tuple(given)
    for name in names:
        require_kind(f"each of {what}", name, str)
    return names


def mapping_of(what: str, given: object) -> Mapping[Any, Any]:
    """Return what is given by name, nothing for None. Raises: `InputError`."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise InputError(f"{what} must be given by name", given=given, remedy="Give a dict")
    return given
