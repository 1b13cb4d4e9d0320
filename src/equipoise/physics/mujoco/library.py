"""MuJoCo, imported when it is first needed, with an error that says what to install."""

from __future__ import annotations

import importlib
from types import ModuleType

from equipoise.errors import InputError


def load_mujoco() -> ModuleType:
    """Return the module `mujoco`.

    Raises: `InputError` naming the extra if it is not installed.
    """
    try:
        return importlib.import_module("mujoco")
    except ImportError as error:
        raise InputError(
            f"the engine mujoco needs the package mujoco ({error})",
            given="physics.engine: mujoco",
            known=("rigid",),
            remedy="Install it with: pip install 'equipoise[mujoco]'",
        ) from None
