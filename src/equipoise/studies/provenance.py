"""Where results come from: versions, the hash of the source, the processor."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from datetime import datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import equipoise

PACKAGES = (
    "numpy", "scipy", "pin", "numba", "mujoco", "daqp", "pydantic", "pyarrow", "distributed",
    "optuna", "example-robot-data",
)  # fmt: skip


def provenance() -> dict[str, Any]:
    """Return what one needs to know to make the same results again."""
    return {
        "equipoise": equipoise.__version__,
        "source": source_hash(),
        "python": sys.version.split()[0],
        "packages": {name: found for name in PACKAGES if (found := _version(name))},
        "platform": platform.platform(),
        "processor": processor(),
        "cores": os.cpu_count(),
        "begun": datetime.now().astimezone().isoformat(timespec="seconds"),
        "command": sys.argv[1:],
    }


@cache
def source_hash() -> str:
    """Return the SHA-256 of all Python and YAML files of the package, by their paths in it."""
    root, total = Path(equipoise.__file__).parent, hashlib.sha256()
    for path in sorted(root.rglob("*")):
        if path.suffix in (".py", ".yaml") and path.is_file():
            total.update(path.relative_to(root).as_posix().encode() + b"\0")
            total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()


def processor() -> str:
    """Return what the processor calls itself."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
