"""Writing to viser's controls."""

from __future__ import annotations

from typing import TypeVar

import viser

Value = TypeVar("Value")


def write(control: viser.GuiInputHandle[Value], value: Value) -> None:
    """Give a control a value, on every page."""
    control.value = value  # type: ignore[misc]  # its setter stands apart from its getter
