"""A viser server that refuses strangers: bound to this machine, guarded, and tested to be so."""

from __future__ import annotations

import http
import http.client
import io
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any
from unittest.mock import patch

import viser
import viser.infra
import websockets.asyncio.server as websocket_server
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from equipoise.errors import EquipoiseError, InputError
from equipoise.viewer.guard import COOKIE, Guard, is_loopback, make_guard
from equipoise.viewer.page_script import asks_for_page, with_script

FIRST_PORT, PORTS = 8080, 100
_opening = threading.Lock()


class UnguardedServerError(EquipoiseError):
    """A server that answered a stranger; it was closed at once."""


class _Server(viser.ViserServer):
    """A viser server that cannot be shared with the internet from the page."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        return None


class _WakefulServer(viser.infra.WebsockServer):
    """Queues messages from any thread.

    viser wakes its sender by an event of asyncio, which is not made for other threads: where the
    sender goes to sleep at that moment, an error says so. By then the message stands in the queue.
    """

    def queue_message(self, message: viser.infra.Message) -> None:
        """Queue a message for all pages."""
        try:
            super().queue_message(message)
        except RuntimeError as error:
            if "mutated during iteration" not in str(error):
                raise
            self.get_message_buffer().flush()


class ViewerServer:
    """A guarded viser server: `viser` is the server, `url` what a person opens (token included).

    Raises: `InputError` if the port is taken or the host is none of this machine.
    """

    def __init__(self, host: str = "127.0.0.1", port: int | None = None) -> None:
        self.guard = make_guard(host)
        wanted = _free_port(host, port)
        with _opening, _quiet(), _guarded(self.guard), _wakeful():
            self.viser = _Server(host=host, port=wanted, label="Equipoise", verbose=False)
        self.host, self.port = host, self.viser.get_port()
        self._require_guarded()
        self.viser.gui.configure_theme(show_logo=False, show_share_button=False)

    @property
    def url(self) -> str:
        """The address of the page."""
        name = self.host if is_loopback(self.host) else _own_address(self.host)
        shown = f"[{name}]" if ":" in name else name
        query = f"?token={self.guard.token}" if self.guard.token else ""
        return f"http://{shown}:{self.port}/{query}"

    def stop(self) -> None:
        """Close the server."""
        with _opening, _quiet():
            self.viser.stop()

    def _require_guarded(self) -> None:
        address = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(self.host, self.host)
        connection = http.client.HTTPConnection(address, self.port, timeout=10.0)
        try:
            connection.request("GET", "/", headers={"Host": "stranger.invalid"})
            status = connection.getresponse().status
        finally:
            connection.close()
        if status != http.HTTPStatus.FORBIDDEN:
            self.stop()
            raise UnguardedServerError(
                f"viser {viser.__version__} let a stranger in (answered {status}); the viewer was "
                "closed. Install the version of viser that pyproject.toml names."
            )


@contextmanager
def _guarded(guard: Guard) -> Iterator[None]:
    """Let the server that is opened meanwhile ask the guard first, also before an upgrade.

    viser offers no place for this, but it calls `websockets.asyncio.server.serve` by this name.
    """
    original = websocket_server.serve

    def serve(handler: Any, host: str, port: int, **options: Any) -> Any:
        options["process_request"] = _checked(options.get("process_request"), guard)
        return original(handler, host, port, **options)

    with patch.object(websocket_server, "serve", serve):
        yield


@contextmanager
def _wakeful() -> Iterator[None]:
    """Let the server that is opened meanwhile take messages from any thread."""
    with patch.object(viser.infra, "WebsockServer", _WakefulServer):
        yield


Answer = Callable[[Any, Request], Response | None]


def _checked(answer: Answer | None, guard: Guard) -> Answer:
    def process(connection: Any, request: Request) -> Response | None:
        reason = guard.refusal(request.path, request.headers)
        if reason is not None:
            return _response(http.HTTPStatus.FORBIDDEN, f"403: {reason}\n")
        if guard.presented_token(request.path):
            cookie = f"{COOKIE}={guard.token}; Path=/; HttpOnly; SameSite=Lax"
            headers = {"Location": "/", "Set-Cookie": cookie, "Referrer-Policy": "no-referrer"}
            return _response(http.HTTPStatus.SEE_OTHER, "", headers)
        is_page = asks_for_page(request)
        response = answer(connection, request) if answer is not None else None
        if response is not None:
            response = with_script(response) if is_page else response
            for name, value in _page_headers(request.headers["Host"]).items():
                response.headers[name] = value
        return response

    return process


def _page_headers(host: str) -> dict[str, str]:
    """Return headers that keep the page from being framed and from talking to anyone else."""
    own = f"'self' ws://{host} wss://{host}"
    policy = (
        "default-src 'self' 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' data: blob:; "
        f"connect-src {own} data: blob:; frame-ancestors 'none'; form-action 'none'; "
        "base-uri 'none'"
    )
    return {
        "Content-Security-Policy": policy,
        "X-Frame-Options": "DENY",
        "X-Content-Type-Options": "nosniff",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Referrer-Policy": "no-referrer",
    }


def _response(status: http.HTTPStatus, text: str, more: dict[str, str] | None = None) -> Response:
    body = text.encode()
    headers = {"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body))}
    return Response(status, status.phrase, Headers({**headers, **(more or {})}), body)


def _free_port(host: str, port: int | None) -> int:
    if port is not None:
        _try_port(host, port)
        return port
    for candidate in range(FIRST_PORT, FIRST_PORT + PORTS - 1):
        try:
            _try_port(host, candidate)
        except InputError:
            continue
        return candidate
    _try_port(host, FIRST_PORT + PORTS - 1)
    return FIRST_PORT + PORTS - 1


def _try_port(host: str, port: int) -> None:
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        with socket.socket(family) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except (OSError, OverflowError) as error:
        raise InputError(
            f"The viewer cannot listen on {host}, port {port}: {error}",
            remedy="Choose another with --port N (and --host), or leave it out",
        ) from error


def _own_address(host: str) -> str:
    """Return the name under which others reach a server bound to `host`."""
    if host not in ("0.0.0.0", "::"):
        return host
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.connect(
                ("192.0.2.1", 9)
            )  # sends nothing: only asks from which address it would go
            return probe.getsockname()[0]
    except OSError:
        return "127.0.0.1"


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep viser's own banner off the terminal: it would show an address without the token."""
    with redirect_stdout(io.StringIO()):
        yield
