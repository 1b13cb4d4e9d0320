"""The page gets its script, and messages of any thread reach the queue."""

from __future__ import annotations

import asyncio
import http.client

import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from websockets.datastructures import Headers
from websockets.http11 import Response

from equipoise.viewer.page_script import SCRIPTS, with_script
from equipoise.viewer.server import ViewerServer


def test_the_page_ends_with_the_script(server: ViewerServer) -> None:
    connection = http.client.HTTPConnection(server.host, server.port, timeout=60.0)
    connection.request("GET", "/", headers={"Accept-Encoding": "gzip"})
    answer = connection.getresponse()
    page = answer.read()
    connection.close()
    assert int(answer.headers["Content-Length"]) == len(page)
    assert page.rstrip().endswith(b"</html>")
    assert all(script.read_bytes() in page[-20_000:] for script in SCRIPTS)


@pytest.mark.parametrize("body", [None, b"", b"no page"])
def test_what_is_no_page_stays_as_it_is(body: bytes | None) -> None:
    response = Response(404, "NOT FOUND", Headers(), body)
    assert with_script(response) is response


def test_a_message_that_meets_the_sender_going_to_sleep_is_queued(
    server: ViewerServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """asyncio's event complains from another thread; nothing is lost and nothing is raised."""
    box = server.viser.gui.add_number("number", 1.0)

    def mutated(_event: asyncio.Event) -> None:
        raise RuntimeError("deque mutated during iteration")

    with monkeypatch.context() as patched:
        patched.setattr(asyncio.Event, "set", mutated)
        box.value = 2.0
    assert box.value == 2.0
    queue = server.viser._websock_server.get_message_buffer()
    last = max(queue.message_from_id)
    assert queue.message_from_id[last].updates == {"value": 2.0}
