"""Names of channels and labels as identifiers that protobuf, and its JSON form, keep apart."""

from __future__ import annotations

import re
from collections.abc import Iterable


def field_names(names: Iterable[str], taken: Iterable[str] = (), stem: str = "x") -> list[str]:
    """Return a legal identifier for each name; none is equal to another, or to one of `taken`.

    `stem` begins those that would not begin with a letter. JSON drops underscores and case, so
    that two names that differ in these only are told apart by a number.
    """
    used = {_folded(name) for name in taken}
    found = []
    for given in names:
        base = re.sub(r"\W+", "_", given, flags=re.ASCII).strip("_")
        base = base if re.match(r"[A-Za-z]", base) else f"{stem}_{base}".rstrip("_")
        name, count = base, 1
        while _folded(name) in used:
            count += 1
            name = f"{base}_n{count}"
        used.add(_folded(name))
        found.append(name)
    return found


def _folded(name: str) -> str:
    return name.replace("_", "").lower()
