"""Sees to it that compiled code is kept, and loaded from, only where nobody else can put any."""

from __future__ import annotations

import logging
import os
import stat
from pathlib import Path

LOG = logging.getLogger(__name__)
OTHERS = stat.S_IWGRP | stat.S_IWOTH


def own_folder(path: Path) -> str:
    """Make a folder that is the user's alone; return why it is not to be trusted, or nothing.

    It must belong to the user and be written by nobody else; every folder above it must belong to
    the user or root and, unless it is sticky as /tmp is, not be written by others.
    """
    path = Path(os.path.abspath(path))
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        path = path.resolve()
        own = path.stat()
        if own.st_uid != os.geteuid():
            return f"{path} belongs to another user"
        if own.st_mode & OTHERS:
            return f"others can write into {path}"
        for folder in path.parents:
            above = folder.stat()
            if above.st_uid not in (0, os.geteuid()):
                return f"{folder} belongs to another user"
            if above.st_mode & OTHERS and not above.st_mode & stat.S_ISVTX:
                return f"others can write into {folder}"
    except OSError as error:
        return f"{path} cannot be used: {error.strerror or error}"
    return ""


def tell_untrusted(why: str) -> None:
    """Say that compiled code is not kept, and what to do."""
    LOG.warning(
        "Compiled code is not kept, so that every start takes a minute: %s. Delete that folder, or "
        "name another, yours alone, in NUMBA_CACHE_DIR.",
        why,
    )
