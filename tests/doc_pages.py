"""The pages of the documentation taken apart: fenced blocks, inline code, links, headings."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("[!_]*.md")]) + sorted(
    page for page in (ROOT / "docs").rglob("*/*.md") if "_build" not in page.parts
)
_FENCE = re.compile(
    r"(?:<!-- not run: (?P<reason>[^>]+) -->\n)?^```(?P<kind>[^\n]*)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
_LINK = re.compile(r"!?\[[^\]]*\]\((?P<target>[^)\s]+)\)")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, its first line, and why it is not run (or "")."""

    kind: str
    text: str
    line: int
    reason: str


def name_of(page: Path) -> str:
    """Return the page's path in the checkout."""
    return str(page.relative_to(ROOT))


def blocks(page: Path, *kinds: str) -> list[Block]:
    """Return the fenced blocks of some languages."""
    text = page.read_text(encoding="utf-8")
    found = [
        Block(
            match["kind"].strip(),
            match["text"],
            text[: match.start("text")].count("\n") + 1,
            (match["reason"] or "").strip(),
        )
        for match in _FENCE.finditer(text)
    ]
    return [block for block in found if block.kind in kinds]


def prose(page: Path) -> str:
    """Return the page without its fenced blocks."""
    return _FENCE.sub("", page.read_text(encoding="utf-8"))


def inline_codes(page: Path) -> list[str]:
    """Return the texts between single backticks outside fenced blocks."""
    return re.findall(r"`([^`\n]+)`", prose(page))


def commands(page: Path, program: str) -> list[str]:
    """Return the command lines of a program, from shell blocks and inline code."""
    lines = [
        line.removeprefix("$ ").split("  #")[0].strip()
        for block in blocks(page, "sh", "console")
        for line in block.text.splitlines()
    ]
    return [line for line in (*lines, *inline_codes(page)) if line.startswith(f"{program} ")]


def links(page: Path) -> list[str]:
    """Return the link targets that stay in the checkout."""
    text = re.sub(r"`[^`\n]*`", "", prose(page))
    found = [match["target"] for match in _LINK.finditer(text)]
    return [target for target in found if not re.match(r"[a-z]+:", target)]


def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings, as GitHub and MyST make them."""
    headings = re.findall(r"^#+ +(.+)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.strip().lower()).replace(" ", "-") for h in headings}


def table_after(page: Path, marker: str) -> list[list[str]]:
    """Return the cells of the rows of the table that follows a comment."""
    text = page.read_text(encoding="utf-8").split(f"<!-- {marker}", 1)[1]
    rows = re.search(r"(?:^\|.*\n)+", text, re.MULTILINE).group().splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]
