"""Reads a URDF or SRDF file into a plain element tree that knows its lines, and refuses bombs.

The tree that was checked is the one Pinocchio is later given, so what is checked is what is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree
from xml.parsers import expat

from equipoise.errors import RobotFileError, quoted

MAX_BYTES = 20_000_000
MAX_NESTING = 64


class Node(ElementTree.Element):
    """An XML element that remembers the line it began on; its children are such elements."""

    line: int | None = None

    if TYPE_CHECKING:

        def find(self, path: str, namespaces: dict[str, str] | None = None) -> Node | None: ...
        def findall(  # type: ignore[override]
            self, path: str, namespaces: dict[str, str] | None = None
        ) -> list[Node]: ...
        def iter(self, tag: str | None = None) -> Iterator[Node]: ...  # type: ignore[override]
        def __iter__(self) -> Iterator[Node]: ...


def read_description(path: Path) -> Node:
    """Read a robot description whose outermost element is <robot>.

    Raises: RobotFileError if it is unreadable, too large, not XML, or carries a DOCTYPE.
    """
    root = parse(read_bytes(path), path)
    if root.tag != "robot":
        raise RobotFileError(
            f"{path} is not a robot description: its outermost element is <{root.tag}>",
            remedy="Give a URDF file; for xacro, expand it first: xacro FILE.xacro > FILE.urdf",
        )
    return root


def parse(content: bytes, path: Path) -> Node:
    """Parse XML without entities.

    Raises: RobotFileError.
    """
    parser = expat.ParserCreate()
    builder: Any = ElementTree.TreeBuilder(element_factory=Node)  # what it builds are Nodes
    depth = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > MAX_NESTING:
            raise RobotFileError(f"{path}: XML nested deeper than {MAX_NESTING} elements")
        builder.start(tag, attributes).line = parser.CurrentLineNumber

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def refuse_doctype(*_: object) -> None:
        raise RobotFileError(
            f"{path}, line {parser.CurrentLineNumber}: a DOCTYPE is not allowed",
            remedy="Remove the DOCTYPE and any ENTITY; a robot description needs neither",
        )

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = refuse_doctype
    try:
        parser.Parse(content, True)
        root: Node = builder.close()
        return root
    except expat.ExpatError as error:
        raise RobotFileError(
            f"{path}, line {error.lineno}: not well-formed XML: {expat.ErrorString(error.code)}"
        ) from error
    except (LookupError, ValueError) as error:
        raise RobotFileError(
            f"{path}: the XML cannot be decoded: {error}", remedy="Save the file as UTF-8"
        ) from error


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file of bounded size. Raises: RobotFileError."""
    try:
        if not path.is_file():
            raise RobotFileError(
                f"There is no file {path}",
                remedy="Give the path of a URDF or MJCF file; for a robot with a name, get_robot",
            )
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise RobotFileError(f"Cannot read {quoted(str(path))}: {error}") from error
    if len(content) > MAX_BYTES:
        raise RobotFileError(
            f"{path} is larger than {MAX_BYTES // 1_000_000} MB",
            remedy="Keep meshes in files of their own",
        )
    return content
