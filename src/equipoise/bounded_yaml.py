"""Reads YAML of strangers within bounds: of size, nodes, depth and repetition by aliases."""

from __future__ import annotations

import re
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    CollectionStartEvent,
    NodeEvent,
    ScalarEvent,
)

from equipoise.errors import one_line, quoted

MOST_CHARACTERS = 1_000_000
MOST_NODES = 20_000  # with what aliases repeat; the largest shipped file has some hundreds
MOST_DEPTH = 40
LONGEST_NUMBER = 400  # digits
TWICE = "a key is given twice (duplicate key)"
_DIGITS = re.compile(r"[+-]?[0-9_]+\Z", re.ASCII)


class BadYamlError(Exception):
    """Text that is not YAML, or not within bounds; `line` is where, from 1, None if unknown."""

    def __init__(self, problem: str, line: int | None = None, remedy: str = "") -> None:
        self.problem, self.line, self.remedy = problem, line, remedy
        super().__init__(problem)


def load_yaml(text: str) -> Any:
    """Return ruamel's tree of YAML 1.2 text, which knows the line of each key.

    Raises: `BadYamlError`.
    """
    if len(text) > MOST_CHARACTERS:
        raise BadYamlError(f"longer than {MOST_CHARACTERS} characters")
    try:
        _check_bounds(text)
        return _reader().load(text)
    except BadYamlError:
        raise
    except DuplicateKeyError as error:
        raise BadYamlError(
            "a key is given twice (duplicate key)", _line(error), "Keep one of the two"
        ) from error
    except MarkedYAMLError as error:
        said = str(error.problem or error.context or "not readable")
        raise BadYamlError(f"not valid YAML: {one_line(said)}", _line(error)) from error
    except YAMLError as error:
        raise BadYamlError(f"not valid YAML: {one_line(str(error))}") from error
    except Exception as error:  # what the library lets through: of tags, dates, huge numbers, keys
        said = f"{type(error).__name__}: {error}"
        raise BadYamlError(f"not readable as YAML: {one_line(said)}") from error


def _reader() -> YAML:
    reader = YAML(typ="rt", pure=True)
    reader.version = (1, 2)
    return reader


def _check_bounds(text: str) -> None:
    """Refuse text that would grow into more nodes, or deeper ones, than a person writes."""
    sizes: dict[str, int] = {}  # of what an anchor stands for, with all that it repeats
    opened: list[tuple[str | None, int, int]] = []  # anchor, nodes before it, line
    count = 0
    for event in _reader().parse(text):
        line = event.start_mark.line + 1
        if isinstance(event, CollectionEndEvent):
            anchor, before, _ = opened.pop()
            if anchor is not None:
                sizes[anchor] = count - before
            continue
        if not isinstance(event, NodeEvent):
            continue
        if isinstance(event, AliasEvent):
            if any(anchor == event.anchor for anchor, _, _ in opened):
                raise BadYamlError(
                    f"the alias {quoted('*' + event.anchor)} stands inside of what it repeats", line
                )
            count += sizes.get(event.anchor, 1)
        else:
            count += 1
        if isinstance(event, ScalarEvent):
            if len(event.value) > LONGEST_NUMBER and _DIGITS.match(event.value):
                raise BadYamlError(f"a number of more than {LONGEST_NUMBER} digits", line)
            if event.anchor is not None:
                sizes[event.anchor] = 1
        if isinstance(event, CollectionStartEvent):
            opened.append((event.anchor, count - 1, line))
        if len(opened) > MOST_DEPTH:
            raise BadYamlError(f"nested deeper than {MOST_DEPTH} levels", line, "Write it flatter")
        if count > MOST_NODES:
            raise BadYamlError(
                f"more than {MOST_NODES} entries, those that aliases repeat among them",
                line,
                "Take out what is not needed, aliases first",
            )


def _line(error: MarkedYAMLError) -> int | None:
    mark = error.problem_mark or error.context_mark
    return None if mark is None else int(mark.line) + 1
