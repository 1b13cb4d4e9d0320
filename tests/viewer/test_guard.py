"""Who the viewer answers: the rules, and a real server that obeys them on both protocols."""

from __future__ import annotations

import base64
import http.client
import os
import socket

import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from websockets.datastructures import Headers

from equipoise.errors import InputError
from equipoise.viewer.guard import COOKIE, Guard, is_loopback, make_guard
from equipoise.viewer.server import ViewerServer

HERE = "127.0.0.1:8080"


def refusal(guard: Guard, target: str = "/", **headers: str) -> str | None:
    return guard.refusal(target, Headers({"Host": HERE} | headers))


def upgrade(**headers: str) -> dict[str, str]:
    return {"Upgrade": "websocket", "Origin": f"http://{HERE}"} | headers


def test_the_own_page_is_answered() -> None:
    guard = make_guard("127.0.0.1")
    assert guard.token is None
    assert refusal(guard) is None
    assert refusal(guard, **upgrade()) is None
    assert refusal(guard, **upgrade(Host="localhost:1", Origin="http://localhost:1")) is None


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "127.0.0.1.evil.example:8080",
        "localhost.evil.example",
        "evil.example@127.0.0.1:8080",
        "192.168.0.7:8080",
        "127.0.0.1:notaport",
        "",
    ],
)
def test_a_foreign_host_is_refused(host: str) -> None:
    assert refusal(make_guard("127.0.0.1"), Host=host) == "foreign Host"


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "http://127.0.0.1",  # another server of this machine
        "http://127.0.0.1:8081",
        "http://localhost:8080",
        "http://127.0.0.1:8080.evil.example",
        "file://127.0.0.1:8080",
        "null",
        "",
    ],
)
def test_a_foreign_origin_is_refused(origin: str) -> None:
    guard = make_guard("127.0.0.1")
    assert refusal(guard, Origin=origin) == "foreign Origin"
    assert refusal(guard, **upgrade(Origin=origin)) == "foreign Origin"


def test_a_websocket_without_an_origin_is_refused_whatever_its_case() -> None:
    guard = make_guard("127.0.0.1")
    for word in ("websocket", "WebSocket"):
        assert refusal(guard, Upgrade=word) == "missing Origin"


def test_two_hosts_or_two_origins_are_refused() -> None:
    guard, twice = make_guard("127.0.0.1"), Headers()
    for value in (HERE, "evil.example"):
        twice["Host"] = value
    assert guard.refusal("/", twice) == "foreign Host"
    origins = Headers({"Host": HERE})
    for value in (f"http://{HERE}", "http://evil.example"):
        origins["Origin"] = value
    assert guard.refusal("/", origins) == "missing Origin"


def test_opened_to_the_network_a_token_is_asked_for() -> None:
    guard = make_guard("0.0.0.0")
    assert guard.token is not None
    assert guard.token != make_guard("0.0.0.0").token
    wrong = "wrong or missing token"
    assert refusal(guard) == wrong
    assert refusal(guard, "/?token=") == wrong
    assert refusal(guard, f"/?token={guard.token}x") == wrong
    assert refusal(guard, f"/?token={guard.token}&token=x") == wrong
    assert refusal(guard, **upgrade()) == wrong
    assert refusal(guard, **upgrade(Cookie=f"{COOKIE}=x; a={guard.token}")) == wrong
    assert refusal(guard, f"/?token={guard.token}") is None
    assert refusal(guard, **upgrade(Cookie=f"a=b; {COOKIE}={guard.token}")) is None
    assert refusal(guard, f"/?token={guard.token}", Host="evil.example") == "foreign Host"
    assert refusal(guard, f"/?token={guard.token}", Host="192.168.0.7:8080") is None


def test_loopback_is_known() -> None:
    assert all(is_loopback(host) for host in ("localhost", "127.0.0.1", "127.9.9.9", "::1"))
    assert not any(is_loopback(host) for host in ("0.0.0.0", "::", "192.168.0.7", "evil.example"))


@pytest.fixture(scope="module")
def closed():
    server = ViewerServer(port=0)
    yield server
    server.stop()


@pytest.fixture(scope="module")
def opened():
    server = ViewerServer("0.0.0.0", port=0)
    yield server
    server.stop()


def get(server: ViewerServer, target: str = "/", **headers: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60.0)
    try:
        connection.request("GET", target, headers=headers)
        response = connection.getresponse()
        response.read()
        return response
    finally:
        connection.close()


def shake_hands(server: ViewerServer, **headers: str) -> int:
    """Return the status that a WebSocket handshake is answered with."""
    lines = {
        "Host": f"127.0.0.1:{server.port}",
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode(),
        "Sec-WebSocket-Version": "13",
    } | headers
    request = "GET / HTTP/1.1\r\n" + "".join(f"{k}: {v}\r\n" for k, v in lines.items()) + "\r\n"
    with socket.create_connection(("127.0.0.1", server.port), timeout=60.0) as stream:
        stream.sendall(request.encode())
        return int(stream.recv(64).split()[1])


def test_a_closed_server_answers_its_own_page_only(closed: ViewerServer) -> None:
    own = f"http://127.0.0.1:{closed.port}"
    assert get(closed).status == 200
    assert get(closed, Host="evil.example").status == 403
    assert get(closed, Origin="http://evil.example").status == 403
    assert shake_hands(closed, Origin=own) == 101
    assert shake_hands(closed, Origin="http://evil.example") == 403
    assert shake_hands(closed) == 403
    assert shake_hands(closed, Host="evil.example", Origin="http://evil.example") == 403


def test_a_closed_server_listens_on_loopback_only(closed: ViewerServer) -> None:
    assert closed.url == f"http://127.0.0.1:{closed.port}/"
    listening = socket.create_connection(("127.0.0.1", closed.port), timeout=60.0)
    listening.close()
    with socket.socket() as probe:
        probe.settimeout(2.0)
        assert probe.connect_ex(("127.0.0.2", closed.port)) != 0


def test_the_page_may_not_be_framed_nor_talk_to_others(closed: ViewerServer) -> None:
    response = get(closed)
    policy = response.headers["Content-Security-Policy"]
    assert "frame-ancestors 'none'" in policy
    assert f"connect-src 'self' ws://127.0.0.1:{closed.port} " in policy
    assert "*" not in policy
    assert response.headers["X-Frame-Options"] == "DENY"


def test_an_opened_server_wants_its_token(opened: ViewerServer) -> None:
    token = opened.guard.token
    assert token is not None
    assert token in opened.url
    own = f"http://127.0.0.1:{opened.port}"
    assert get(opened).status == 403
    assert get(opened, "/?token=wrong").status == 403
    assert shake_hands(opened, Origin=own) == 403
    welcome = get(opened, f"/?token={token}")
    assert welcome.status == 303
    assert welcome.headers["Location"] == "/"
    cookie = welcome.headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite" in cookie
    pair = cookie.split(";")[0]
    assert get(opened, Cookie=pair).status == 200
    assert shake_hands(opened, Origin=own, Cookie=pair) == 101
    assert shake_hands(opened, Origin="http://evil.example", Cookie=pair) == 403


def test_a_server_that_lets_strangers_in_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    from equipoise.viewer.server import UnguardedServerError

    monkeypatch.setattr(Guard, "refusal", lambda *_: None)
    with pytest.raises(UnguardedServerError, match="let a stranger in"):
        ViewerServer(port=0)


def test_a_taken_port_is_named(closed: ViewerServer) -> None:
    with pytest.raises(InputError, match=rf"port {closed.port}.*--port N"):
        ViewerServer(port=closed.port)
    with pytest.raises(InputError, match=r"cannot listen on 192\.0\.2\.1"):
        ViewerServer("192.0.2.1", port=0)


def test_nobody_can_share_the_page_with_the_internet(closed: ViewerServer) -> None:
    assert closed.viser.request_share_url() is None
