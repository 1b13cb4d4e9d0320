"""Gymnasium, or an error that says what to install."""

from __future__ import annotations

import importlib

from equipoise.errors import InputError


def require_gymnasium() -> None:
    """Import Gymnasium. Raises: `InputError` naming the extra if it is not installed."""
    try:
        importlib.import_module("gymnasium")
    except ImportError as error:
        raise InputError(
            f"equipoise.gym needs the package gymnasium ({error})",
            remedy="Install it with: pip install 'equipoise[gym]'",
        ) from None
