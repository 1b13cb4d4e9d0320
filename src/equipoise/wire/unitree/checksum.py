"""The checksum of `unitree_hg`: CRC-32/MPEG-2 over words, four table look-ups a word.

Source: the CRC of Unitree's public Python SDK: polynomial 0x04C11DB7, begun with all ones, over
words of 32 bits with the highest byte first.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled import entrance

POLYNOMIAL, BEGIN = 0x04C11DB7, 0xFFFFFFFF


def _tables() -> np.ndarray:
    """Return by place k and byte the CRC of that byte with k zero bytes behind it (4, 256)."""
    tables = np.zeros((4, 256), dtype=np.int64)
    for byte in range(256):
        crc = byte << 24
        for k in range(4):
            for _ in range(8):
                crc = ((crc << 1) ^ POLYNOMIAL if crc & 0x80000000 else crc << 1) & 0xFFFFFFFF
            tables[k, byte] = crc
    return tables


TABLES = _tables()


@entrance
def crc_of_words(words: np.ndarray, count: int, tables: np.ndarray) -> int:
    """Return the CRC of the first words of a message."""
    crc = 0xFFFFFFFF
    for k in range(count):
        x = crc ^ np.int64(words[k])
        crc = (
            tables[3, (x >> 24) & 255]
            ^ tables[2, (x >> 16) & 255]
            ^ tables[1, (x >> 8) & 255]
            ^ tables[0, x & 255]
        )
    return crc


def checksum(memory: bytes) -> int:
    """Return the CRC of a message in memory; its last word, the CRC itself, is left out."""
    words = np.frombuffer(memory, "<u4")
    return int(crc_of_words(words, len(words) - 1, TABLES))
