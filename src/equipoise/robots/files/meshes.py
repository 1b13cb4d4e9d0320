"""Finds mesh files, and only inside the folders they may lie in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from equipoise.robots.files.description import Node
from equipoise.robots.files.values import Report, element, read_numbers

FORMATS = (".stl", ".dae", ".obj", ".ply", ".off")
PACKAGE = "package://"
MAX_MESH_BYTES = 200_000_000


class MeshFolders:
    """Resolve a URDF's mesh paths.

    `package://NAME/...` is looked for in each of `package_dirs`, then in the folders above the
    URDF that are called NAME; other paths start at the URDF's own folder.
    """

    def __init__(self, urdf: Path, package_dirs: Sequence[str | Path] = ()) -> None:
        self._home = urdf.resolve().parent
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
        if roots is None:
            problem = "a mesh path must be package://NAME/... or relative to the URDF"
            return None, problem, "Put the mesh in the robot's package and name it so"
        if not roots:
            return None, "the package folder was not found", "Name its parent in package_dirs"
        for root in roots:
            try:
                path = (root / rest).resolve()
                inside, exists = path.is_relative_to(root), path.is_file()
                size = path.stat().st_size if inside and exists else 0
            except (OSError, ValueError, RuntimeError) as error:
                return None, f"the mesh path cannot be read ({error})", "Correct the path"
            if not inside:
                return None, f"the mesh lies outside its folder {root}", "Move it inside"
            if exists and path.suffix.lower() not in FORMATS:
                return None, "unknown mesh format", f"Use one of {', '.join(FORMATS)}"
            if size > MAX_MESH_BYTES:
                return None, "the mesh file is larger than 200 MB", "Simplify the mesh"
            if exists:
                return path, "", ""
        return None, f"there is no mesh file {roots[0] / rest}", "Correct the path"

    def _candidates(self, given: str) -> tuple[list[Path] | None, str]:
        """Return the folders a mesh may lie in and its path there; None for a refused form."""
        if given.startswith(PACKAGE):
            name, _, rest = given[len(PACKAGE) :].partition("/")
            if name in ("", ".", ".."):
                return None, ""
            roots = [folder / name for folder in self._package_dirs if (folder / name).is_dir()]
            roots += [folder for folder in (self._home, *self._home.parents) if folder.name == name]
            return [root.resolve() for root in roots], rest
        if not given or "://" in given or given.startswith(("/", "~", "\\")) or ":" in given[:3]:
            return None, ""
        return [self._home], given
