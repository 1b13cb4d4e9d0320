"""How Sphinx builds the site: MyST pages, the furo theme, tables made from the code."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from generate_keys import write_tables  # noqa: E402

from equipoise import __version__  # noqa: E402

write_tables()

project = "Equipoise"
author = "the Equipoise authors"
copyright = author
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False
html_theme = "furo"
html_title = "Equipoise"
html_baseurl = ""
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
add_module_names = False
nitpicky = False
suppress_warnings = ["misc.highlighting_failure"]
REPOSITORY_FILES = "../"
