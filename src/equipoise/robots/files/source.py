"""Finds the files of a robot: a URDF, or a YAML that names one beside it or in a package."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from equipoise.errors import RobotFileError
from equipoise.robots.files.description import Node, read_description
from equipoise.robots.files.extras import read_extras
from equipoise.robots.files.extras_schema import Extras, SourceEntry
from equipoise.robots.files.laws import Law
from equipoise.robots.files.mimic import take_laws
from equipoise.robots.files.supplement import supplement

YAML = (".yaml", ".yml")
URDF = (".urdf", ".xml")


class ExtraMissingError(RobotFileError):
    """A robot whose files come with a package that is not installed."""


@dataclass(frozen=True)
class Source:
    """The files of a robot: its URDF, if any its SRDF, and what its YAML (if it exists) says."""

    urdf: Path
    yaml: Path
    srdf: Path | None
    extras: Extras

    def tree(self) -> tuple[Node, list[Law], set[str]]:
        """Return the URDF's tree, completed and corrected as the YAML says.

        The second part are the joints that follow others, the third those that were locked with
        their leader.
        Raises: RobotFileError, NameNotFoundError.
        """
        tree = supplement(read_description(self.urdf), self.extras)
        return tree, *take_laws(tree, self.extras)


def find_source(
    path: str | Path,
    *,
    srdf_path: str | Path | None = None,
    extras_path: str | Path | None = None,
) -> Source:
    """Return the files of a robot from its URDF, its YAML, or a folder that holds one of them.

    What is not given is looked for beside `path` under the same stem.
    Raises: RobotFileError.
    """
    main_file = _in_folder(Path(path))
    if main_file.suffix.lower() in YAML:
        extras = read_extras(main_file)
        srdf = companion(main_file, srdf_path, ".srdf")
        return Source(urdf_of(main_file, extras), main_file, srdf, extras)
    yaml = companion(main_file, extras_path, ".yaml")
    extras = read_extras(yaml) if yaml else Extras()
    srdf = companion(main_file, srdf_path, ".srdf")
    return Source(main_file, yaml or main_file.with_suffix(".yaml"), srdf, extras)


def urdf_of(yaml: Path, extras: Extras) -> Path:
    """Return the URDF or MJCF that a robot's YAML names; by default the one beside it.

    Raises: RobotFileError.
    """
    named = extras.urdf or extras.mjcf
    if isinstance(named, SourceEntry):
        return file_of_package(named)
    beside = [yaml.with_suffix(suffix) for suffix in URDF]
    urdf = next((path for path in beside if path.is_file()), beside[0])
    urdf = urdf if named is None else yaml.parent / named
    if not urdf.is_file():
        raise RobotFileError(f"{yaml}: there is no URDF {urdf}", remedy="Name it with the key urdf")
    return urdf


def file_of_package(source: SourceEntry) -> Path:
    """Return a file of an installed package.

    Raises: ExtraMissingError, RobotFileError.
    """
    try:
        files = metadata.files(source.package)
    except metadata.PackageNotFoundError:
        raise ExtraMissingError(
            f"This robot's files come with the package {source.package}, which is not installed",
            remedy=f"pip install {_what_brings(source)}",
        ) from None
    wanted = Path(source.file).parts
    for file in files or ():
        if file.parts[-len(wanted) :] == wanted:
            return Path(str(file.locate())).resolve()
    raise RobotFileError(
        f"The package {source.package} {metadata.version(source.package)} has no such file",
        given=source.file,
        remedy="Name a file of it with its folder, or install another version of the package",
    )


def _what_brings(source: SourceEntry) -> str:
    return f"'equipoise[{source.extra}]'" if source.extra else source.package


def companion(main_file: Path, given: str | Path | None, suffix: str) -> Path | None:
    """Return the given path, or the file of the same stem beside `main_file`, or None."""
    if given is not None:
        path = Path(given)
        if not path.is_file():
            raise RobotFileError(
                f"There is no file {path}", remedy=f"Give the {suffix} file's path"
            )
        return path
    sibling = main_file.with_suffix(suffix)
    return sibling if sibling.is_file() else None


def _in_folder(path: Path) -> Path:
    """Return the YAML or URDF of a folder that is named like it; other paths as they are."""
    if not path.is_dir():
        return path
    stem = path.resolve().name
    for suffix in (*YAML, *URDF):
        if (path / f"{stem}{suffix}").is_file():
            return path / f"{stem}{suffix}"
    raise RobotFileError(
        f"The folder {path} holds no robot", remedy=f"Name its file {stem}.yaml or {stem}.urdf"
    )
