"""Text files that a person names: what is missing, too large or no text is told in a sentence."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from equipoise.errors import ScenarioError

MOST_BYTES = 4_000_000


def text_of_file(path: Path, kind: str, known: Iterable[str] = ()) -> str:
    """Return the text of a file that should hold a `kind` (scenario, study, ...).

    `known` are the names of those that are shipped. Raises: `ScenarioError`.
    """
    known = tuple(known)
    remedy = f"Give a YAML file, or the name of a shipped {kind}" if known else "Give a YAML file"
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):  # a pipe or a device
            raise ScenarioError(f"{path} is not a file", known=known, remedy=remedy)
        if path.stat().st_size > MOST_BYTES:
            size = f"{MOST_BYTES // 1_000_000} MB"
            raise ScenarioError(f"{path}: the {kind} file is larger than {size}", remedy=remedy)
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        problem = f"there is no file {path}"
        raise ScenarioError(problem, known=known, remedy=remedy) from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{path} is no text, hence no {kind}", remedy=remedy) from None
    except (OSError, ValueError) as error:  # ValueError: no path at all
        why = str(getattr(error, "strerror", None) or error).lower()
        raise ScenarioError(f"{path} cannot be read: {why}", remedy=remedy) from None
    if not text.isprintable() and any(ord(c) < 32 and c not in "\t\n\r\f" for c in text):
        raise ScenarioError(f"{path} is no text, hence no {kind}", remedy=remedy)
    return text
