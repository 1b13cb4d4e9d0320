"""Meshes kept in the user's cache once they are simplified: reading them again takes a moment."""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

import coal
import numpy as np

from equipoise.analysis.rendering.looks.mesh_files import MeshFile
from equipoise.analysis.rendering.looks.simplify import Triangles, simplified
from equipoise.analysis.rendering.tessellation import Mesh
from equipoise.compiled.own_folder import own_folder

VERSION = 4  # of what is kept; another one is made anew
_ARRAYS = ("vertices", "normals", "triangles")


def meshes_of(files: Sequence[MeshFile], most: int) -> list[Mesh]:
    """Return the triangles of mesh files in metres, about `most` together.

    A file that cannot be read has none.
    """
    kept = _place(files, most)
    if kept is not None and (meshes := _read(kept, len(files))) is not None:
        return meshes
    meshes = simplified([_load(file) for file in files], most)
    if kept is not None:
        _write(kept, meshes)
    return meshes


def _load(file: MeshFile) -> Triangles:
    try:
        model = coal.MeshLoader().load(str(file.path), file.scale)
        vertices = np.array(model.vertices(), dtype=float).reshape(-1, 3)
        faces = [model.tri_indices(i) for i in range(model.num_tris)]
    except (RuntimeError, ValueError):
        return np.empty((0, 3)), np.empty((0, 3), dtype=int)
    if not np.isfinite(vertices).all():
        return np.empty((0, 3)), np.empty((0, 3), dtype=int)
    return vertices, np.array([[f[0], f[1], f[2]] for f in faces], dtype=int).reshape(-1, 3)


def _place(files: Sequence[MeshFile], most: int) -> Path | None:
    """Return where the meshes are kept, by what they are made of; None where nothing can be."""
    about = [f"{VERSION} {most} {find_spec('fast_simplification') is not None}"]
    try:
        for file in files:
            told = file.path.stat()
            about.append(f"{file.path} {told.st_size} {told.st_mtime_ns} {file.scale.tolist()}")
        home = os.environ.get("XDG_CACHE_HOME")
        folder = (Path(home) if home else Path.home() / ".cache") / "equipoise" / "meshes"
    except (OSError, RuntimeError):
        return None
    if own_folder(folder.parent) or own_folder(folder):
        return None
    return folder / f"{hashlib.sha256(chr(10).join(about).encode()).hexdigest()[:32]}.npz"


def _read(kept: Path, count: int) -> list[Mesh] | None:
    try:
        with np.load(kept, allow_pickle=False) as arrays:
            meshes = [Mesh(*(arrays[f"{name}{k}"] for name in _ARRAYS)) for k in range(count)]
    except (OSError, ValueError, KeyError, zipfile.BadZipFile):
        return None
    return meshes if all(_is_whole(mesh) for mesh in meshes) else None


def _is_whole(mesh: Mesh) -> bool:
    shape = (len(mesh.vertices), 3)
    if not mesh.vertices.shape == mesh.normals.shape == shape:
        return False
    inside = (mesh.triangles >= 0) & (mesh.triangles < shape[0])
    return mesh.triangles.ndim == 2 and mesh.triangles.shape[1] == 3 and bool(inside.all())


def _write(kept: Path, meshes: Sequence[Mesh]) -> None:
    beside = kept.with_suffix(f".{os.getpid()}.part")
    arrays = {
        f"{name}{k}": getattr(mesh, name) for k, mesh in enumerate(meshes) for name in _ARRAYS
    }
    with suppress(OSError):
        with open(beside, "wb") as stream:
            np.savez(stream, **arrays)
        os.replace(beside, kept)
