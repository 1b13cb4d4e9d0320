"""How Sphinx builds the site: MyST pages, the furo theme, tables made from the code."""

from __future__ import annotations

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from docutils.nodes import SkipNode
from generate_keys import write_tables
from latex2mathml.converter import convert

from equipoise import __version__

write_tables()

project = "Equipoise"
author = "the Equipoise authors"
version = release = __version__
html_show_copyright = False
extensions = ["myst_parser", "sphinx.ext.autodoc"]
html_math_renderer = "mathml"  # browsers draw it themselves: no page asks a network for anything
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
myst_fence_as_directive = ["math"]  # written as GitHub reads it
html_theme = "furo"
html_title = "Equipoise"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
add_module_names = False


def show_as_written(app, what, name, thing, options, lines: list[str]) -> None:
    """Make reStructuredText of a docstring that is plain text with `code` in backticks."""
    for i, line in enumerate(lines):
        parts = re.split(r"`+([^`]+)`+", line)
        parts[::2] = [re.sub(r"([|*\\_])", r"\\\1", part) for part in parts[::2]]
        parts[1::2] = [rf"\ ``{part}``\ " for part in parts[1::2]]
        indent = re.match(r"\s*", line).group()
        lines[i] = indent + "".join(parts)[len(indent) :]


def write_inline_math(writer, node) -> None:
    """Write a formula of a line as MathML."""
    writer.body.append(convert(node.astext()))
    raise SkipNode


def write_block_math(writer, node) -> None:
    """Write a formula that stands alone as MathML."""
    text = node.astext()
    if ("&" in text or r"\\" in text) and r"\begin" not in text:
        text = rf"\begin{{aligned}}{text}\end{{aligned}}"
    text = text.replace("{aligned}", "{align*}")  # as latex2mathml knows it
    formula = convert(text, display="block")
    writer.body.append(f'<div style="overflow: auto hidden; padding: 0.5em 0">{formula}</div>')
    raise SkipNode


def setup(app) -> None:
    """Register the hook and how formulas are written."""
    app.connect("autodoc-process-docstring", show_as_written)
    app.add_html_math_renderer("mathml", (write_inline_math, None), (write_block_math, None))
