"""Fixtures of the viewer: a made-up log, and a guarded server."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from viewer_logs import write_sway

if TYPE_CHECKING:
    from equipoise.viewer.server import ViewerServer


@pytest.fixture(scope="session")
def sway(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a made-up log of 0.9 s."""
    return write_sway(tmp_path_factory.mktemp("sway") / "sway", 900)


@pytest.fixture
def server() -> Iterator[ViewerServer]:
    """A guarded server on a free port."""
    from equipoise.viewer.server import ViewerServer

    server = ViewerServer(port=0)
    yield server
    server.stop()
