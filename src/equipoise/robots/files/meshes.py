"""Finds mesh files, and only inside the folders they may lie in."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from equipoise.errors import one_line, quoted
from equipoise.robots.files.description import Node
from equipoise.robots.files.values import Report, element, read_numbers

FORMATS = (".stl", ".dae", ".obj", ".ply", ".off")
PACKAGE = "package://"
MAX_MESH_BYTES = 200_000_000
PACKAGE_DEPTH = 6  # folders above a URDF that are looked through for a package.xml


class MeshFolders:
    """Resolve a URDF's mesh paths.

    `package://NAME/...` is looked for in each of `package_dirs`, then in the folders above the
    URDF that are called NAME; other paths start at the URDF's own folder. Nothing is read that
    lies, once links are followed, outside: of the package's folder; for other paths, of the
    package that the URDF is in (the nearest folder above with a package.xml) or else of the folder
    that holds the URDF's, so that ../meshes/x.stl is found.
    """

    def __init__(self, urdf: Path, package_dirs: Sequence[str | Path] = ()) -> None:
        self._home = urdf.resolve().parent
        self._around = around(self._home)
        self._package_dirs = [Path(folder).resolve() for folder in package_dirs]

    def checked(self, report: Report, node: Node, place: str) -> Node | None:
        """Return a clean <mesh> with an absolute path, or None after reporting what is wrong."""
        given = node.get("filename", "")
        path, problem, remedy = self._resolve(given)
        if path is None:
            report.error(node, place, problem, given=given, remedy=remedy)
            return None
        scale: tuple[float, ...] = (1.0, 1.0, 1.0)
        if node.get("scale") is not None:
            read = read_numbers(report, node, place, "scale", 3)
            if read is None or 0.0 in read:
                if read is not None:
                    report.error(node, place, "a mesh scale is zero", given=node.get("scale"))
                return None
            scale = read
        return element("mesh", filename=str(path), scale=scale)

    def _resolve(self, given: str) -> tuple[Path | None, str, str]:
        """Return (path, "", "") or (None, problem, remedy)."""
        roots, rest = self._candidates(given)
        relative = not given.startswith(PACKAGE)
        if roots is None:
            problem = "a mesh path must be package://NAME/... or relative to the URDF"
            return None, problem, "Put the mesh in the robot's package and name it so"
        if not roots:
            return None, "the package folder was not found", "Name its parent in package_dirs"
        for root in roots:
            try:
                path = (root / rest).resolve()
                within = self._around if root == self._home and relative else root
                inside, exists = path.is_relative_to(within), path.is_file()
                size = path.stat().st_size if inside and exists else 0
            except (OSError, ValueError, RuntimeError) as error:
                return None, f"the mesh path cannot be read ({one_line(error)})", "Correct the path"
            if not inside:
                return None, f"the mesh lies outside its folder {within}", "Move it inside"
            if exists and path.suffix.lower() not in FORMATS:
                return None, "unknown mesh format", f"Use one of {', '.join(FORMATS)}"
            if size > MAX_MESH_BYTES:
                return None, "the mesh file is larger than 200 MB", "Simplify the mesh"
            other = _library_outside(path, within) if exists else ""
            if other:
                problem = f"the mesh names a material library outside the folder {within}: {other}"
                return None, problem, "Take the line 'mtllib' out of the mesh file"
            if exists:
                return path, "", ""
        return None, f"there is no mesh file {quoted(str(roots[0] / rest))}", "Correct the path"

    def _candidates(self, given: str) -> tuple[list[Path] | None, str]:
        """Return the folders a mesh may lie in and its path there; None for a refused form."""
        if given.startswith(PACKAGE):
            # three slashes are a slip of old exporters
            name, _, rest = given[len(PACKAGE) :].removeprefix("/").partition("/")
            if name in ("", ".", ".."):
                return None, ""
            roots = [folder / name for folder in self._package_dirs if (folder / name).is_dir()]
            roots += [folder for folder in (self._home, *self._home.parents) if folder.name == name]
            return [root.resolve() for root in roots], rest
        if not given or "://" in given or given.startswith(("/", "~", "\\")) or ":" in given[:3]:
            return None, ""
        return [self._home], given


def around(home: Path) -> Path:
    """Return the folder that a URDF's relative mesh paths may lead about in."""
    above = [folder for folder in (home, *home.parents) if folder.parent != folder]
    for folder in above[:PACKAGE_DEPTH]:
        if (folder / "package.xml").is_file():
            return folder
    return above[1] if len(above) > 1 else home


def _library_outside(mesh: Path, folder: Path) -> str:
    """Return the material library outside of a folder that an OBJ file names, or nothing."""
    if mesh.suffix.lower() != ".obj":
        return ""
    for name in re.findall(rb"^\s*mtllib\s+(.+?)\s*$", mesh.read_bytes(), re.M):
        text = name.decode("utf-8", "replace")
        for one in (text, *text.split()):
            if not (mesh.parent / one).resolve().is_relative_to(folder):
                return quoted(one)
    return ""
