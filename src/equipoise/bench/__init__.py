"""Measures how long a tick takes, side by side with peers; reads and compares kept results."""

from equipoise.bench.rows import Row, read_rows, write_rows

__all__ = ["Row", "read_rows", "write_rows"]
