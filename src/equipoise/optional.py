"""Packages that control does not need: asked for where they are, with the extra that has them."""

from __future__ import annotations

from importlib.util import find_spec

from equipoise.errors import InputError


def is_installed(package: str) -> bool:
    """Return whether a package can be imported."""
    try:
        return find_spec(package) is not None
    except (ImportError, ValueError):  # somebody hid it
        return False


def require_package(package: str, extra: str, what: str) -> None:
    """Refuse to go on without a package. Raises: `InputError` naming the extra that brings it."""
    if not is_installed(package):
        raise InputError(
            f"{what} needs the package {package}, which is not installed",
            remedy=f"Install it with: pip install 'equipoise[{extra}]'",
        )
