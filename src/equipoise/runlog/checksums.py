"""Checksums of what a log says about itself: names of channels, units, scenario, versions."""

from __future__ import annotations

import zlib
from collections.abc import Mapping

SUMS = "equipoise.sums"
Metadata = Mapping[str, Mapping[str, str]]


def checksums(metadata: Metadata) -> dict[str, str]:
    """Return the CRC-32 of each text, in hexadecimal, by "name/key"."""
    return {
        f"{name}/{key}": _sum(text)
        for name, content in metadata.items()
        for key, text in content.items()
    }


def damaged_texts(metadata: Metadata) -> list[str]:
    """Return the names "name/key" of texts that are not what was written, gone or new ones too.

    Without any checksums all of them count as damaged: whoever calls knows that there should be
    some.
    """
    wanted = metadata.get(SUMS, {})
    found = checksums({name: content for name, content in metadata.items() if name != SUMS})
    return sorted(name for name in {*wanted, *found} if wanted.get(name) != found.get(name))


def _sum(text: str) -> str:
    return f"{zlib.crc32(text.encode('utf-8', 'surrogatepass')):08x}"
