"""Reads an MJCF within bounds, and leaves only what says something of the robot.

MuJoCo itself would open any file that the text names. So includes are taken in here, meshes are
read here and handed over as bytes, and what else could name a file is taken out or refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path, PureWindowsPath
from xml.etree import ElementTree

from equipoise.errors import RobotFileError, one_line, quoted
from equipoise.robots.files.description import Node, parse, read_bytes
from equipoise.robots.files.meshes import around

ROOT = "mujoco"
MOST_INCLUDES, MOST_ELEMENTS, MOST_BYTES = 64, 50_000, 500_000_000
DEEPEST = 8  # includes in one another
MESHES = (".stl", ".obj", ".msh")
READ = (
    *("compiler", "default", "asset", "worldbody", "contact", "equality", "tendon"),
    *("actuator", "keyframe"),
)
# what says nothing of the body of a robot, wherever it stands
DROPPED = frozenset({"light", "camera", "texture", "hfield", "skin", "layer", "pair"})
REFUSED = {
    "extension": "Plugins are programs: a robot is read without them",
    "plugin": "Plugins are programs: a robot is read without them",
    "attach": "Write the attached model into the file",
    "model": "Write the attached model into the file",
    "replicate": "Write the copies out: python -m mujoco.compile or MjSpec.to_xml does it",
    "composite": "Write the bodies out, or leave them out",
    "flexcomp": "A robot is made of rigid bodies: leave it out",
    "flex": "A robot is made of rigid bodies: leave it out",
}
FILES = ("meshdir", "texturedir", "assetdir", "strippath")
UNUSED = (*FILES, "fusestatic", "discardvisual", "usethread")


@dataclass
class MjcfText:
    """A text that names no files, and the bytes of the meshes it asks for by name."""

    xml: str
    meshes: dict[str, bytes] = field(default_factory=dict)


def is_mjcf(path: Path) -> bool:
    """Say whether the outermost element of an XML file is that of an MJCF.

    Raises: RobotFileError if it cannot be read.
    """
    return path.suffix.lower() != ".urdf" and parse(read_bytes(path), path).tag == ROOT


def read_mjcf(path: Path) -> MjcfText:
    """Return the text of an MJCF with its includes, and its meshes.

    Nothing is read outside of the nearest folder above with a package.xml, or else of the folder
    that holds the file's own.
    Raises: RobotFileError.
    """
    reader = _Reader(path)
    root = reader.whole()
    text = MjcfText("")
    for node in [child for child in root if child.tag not in (*READ, *REFUSED)]:
        root.remove(node)
    folder = _mesh_folder(root)
    _clean(root, path)
    reader.take_meshes(root, folder, text)
    for node in root.iter():
        given = next((key for key in node.attrib if key.startswith("file")), None)
        if given is not None and node.tag != "mesh":
            raise reader.error(node, f"<{node.tag} {given}> names a file", "Take it out")
    text.xml = ElementTree.tostring(root, encoding="unicode")
    return text


class _Reader:
    """Reads the files of one model, and counts what it reads."""

    def __init__(self, path: Path) -> None:
        self.path, self.home = path, path.resolve().parent
        self.around = around(self.home)
        self.includes, self.bytes = 0, 0

    def error(self, node: Node, problem: str, remedy: str = "") -> RobotFileError:
        line = f", line {node.line}" if node.line is not None else ""
        return RobotFileError(f"{self.path}{line}: {problem}", remedy=remedy)

    def whole(self) -> Node:
        """Return the tree with every include taken in."""
        root = parse(read_bytes(self.path), self.path)
        if root.tag != ROOT:
            raise RobotFileError(
                f"{self.path} is no MJCF: its outermost element is <{root.tag}>",
                remedy="An MJCF begins with <mujoco>",
            )
        self._include(root, 0)
        if sum(1 for _ in root.iter()) > MOST_ELEMENTS:
            raise RobotFileError(f"{self.path} has more than {MOST_ELEMENTS} elements")
        return root

    def _include(self, node: Node, depth: int) -> None:
        children: list[Node] = []
        for child in list(node):
            if child.tag != "include":
                self._include(child, depth)
                children.append(child)
                continue
            self.includes += 1
            if depth >= DEEPEST or self.includes > MOST_INCLUDES:
                limits = f"{DEEPEST} in one another, {MOST_INCLUDES} in all"
                raise self.error(child, f"too many includes; at most {limits}")
            file = self.inside(child, child.get("file", ""), self.home)
            part = parse(self.taken(child, file), file)
            self._include(part, depth + 1)
            children += list(part)
        node[:] = children

    def inside(self, node: Node, given: str, folder: Path) -> Path:
        """Return the path of a file that a model names. Raises: RobotFileError."""
        if not given or PureWindowsPath(given).is_absolute() or given.startswith(("/", "~", "\\")):
            raise self.error(
                node, f"a file must be named from the model's folder, not {quoted(given)}",
                "Name it without the folders above",
            )  # fmt: skip
        try:
            path = (folder / given).resolve()
            if not path.is_relative_to(self.around):
                raise self.error(
                    node, f"{quoted(given)} lies outside of the folder {self.around}",
                    "Move it inside",
                )  # fmt: skip
            if not path.is_file():
                raise self.error(node, f"there is no file {quoted(str(path))}", "Correct the path")
        except (OSError, ValueError, RuntimeError) as error:
            raise self.error(node, f"{quoted(given)} cannot be read: {one_line(error)}") from error
        return path

    def taken(self, node: Node, path: Path) -> bytes:
        """Return the bytes of a file. Raises: RobotFileError if all are more than too many."""
        try:
            self.bytes += path.stat().st_size
            if self.bytes > MOST_BYTES:
                raise self.error(node, f"its files are larger than {MOST_BYTES // 1_000_000} MB")
            return path.read_bytes()
        except OSError as error:
            raise self.error(node, f"{path.name} cannot be read: {one_line(error)}") from error

    def take_meshes(self, root: Node, folder: tuple[str, bool], text: MjcfText) -> None:
        """Read the meshes; each is then named by its number, and called as MuJoCo would."""
        within, bare = folder
        for node in [mesh for asset in root.findall("asset") for mesh in asset.findall("mesh")]:
            given = node.get("file")
            if given is None:
                continue
            given = PureWindowsPath(given).name if bare else given
            path = self.inside(node, str(Path(within) / given) if within else given, self.home)
            if path.suffix.lower() not in MESHES:
                known = ", ".join(MESHES)
                raise self.error(node, f"unknown mesh format {quoted(path.name)}", f"Use {known}")
            key = f"{len(text.meshes)}{path.suffix.lower()}"
            text.meshes[key] = self.taken(node, path)
            node.set("name", node.get("name") or PureWindowsPath(given).stem)
            node.set("file", key)


def _mesh_folder(root: Node) -> tuple[str, bool]:
    """Return where meshes lie, and whether only their bare names count; forget both."""
    folder, bare = "", False
    for compiler in root.findall("compiler"):
        folder = compiler.get("meshdir") or compiler.get("assetdir") or folder
        bare = compiler.get("strippath", str(bare)).lower() == "true"
        for key in UNUSED:
            compiler.attrib.pop(key, None)
    return folder, bare


def _clean(root: Node, path: Path) -> None:
    """Take out what says nothing of the robot; refuse what cannot be read without running it."""
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in REFUSED and not (child.tag == "model" and parent.tag != "asset"):
                line = f", line {child.line}" if child.line is not None else ""
                raise RobotFileError(
                    f"{path}{line}: <{child.tag}> is not read", remedy=REFUSED[str(child.tag)]
                )
            if child.tag in DROPPED or (child.tag == "geom" and child.get("type") == "hfield"):
                parent.remove(child)
        if parent.tag == "material":
            parent.attrib.pop("texture", None)
