"""Text of strangers (titles, names, notes) made safe for where the page reads markup."""

from __future__ import annotations

import re

_PLAIN = re.compile(r"[^A-Za-z0-9 ,;/]")  # all else may begin markup


def in_markdown(text: object) -> str:
    """Return text that Markdown shows as it is, on one line.

    The page's Markdown may hold HTML and expressions, so that every sign that could begin one is
    written by its number.
    """
    return _PLAIN.sub(_by_number, " ".join(str(text).split()))


def _by_number(match: re.Match[str]) -> str:
    """Return a sign as its number; letters beyond ASCII mean nothing to Markdown."""
    sign = match[0]
    return f"&#{ord(sign)};" if sign.isascii() else sign
