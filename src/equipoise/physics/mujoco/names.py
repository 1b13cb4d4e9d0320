"""Every name in a generated model: a kind, a slash, and what is named.

Robots, contacts and objects bring names of their own; no two of them, and none of ours, can meet in
a model where nothing stands under a bare name of the user's.
"""

from __future__ import annotations

BASE = "robot"  # the base's body and its free joint
FLOOR = "floor"


def in_model(kind: str, what: str | int, number: int | None = None) -> str:
    """Return the name of something of a kind, the `number`-th of its kind that belongs to `what`.

    Free text stands last, so that different arguments give different names.
    """
    return f"{kind}/{what}" if number is None else f"{kind}/{number}/{what}"


def of_joint(joint: str) -> str:
    """Return the name of a robot's joint, and of the body that it moves."""
    return in_model(BASE, joint)


def of_object(name: str) -> str:
    """Return the name of a loose object's body, and of its free joint."""
    return in_model("object", name)
