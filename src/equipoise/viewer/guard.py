"""Who may talk to the viewer: Host, Origin and token of every request, decided in one place.

A page from elsewhere that runs in the same browser can reach 127.0.0.1 too. What stops it is that
browsers always tell the page's Origin to a WebSocket, and that a name which an attacker points to
127.0.0.1 (DNS rebinding) still stands in Host.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Protocol
from urllib.parse import parse_qs, urlsplit

COOKIE = "equipoise_viewer"
LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})


class Headers(Protocol):
    """What the guard needs of a request's headers."""

    def get_all(self, key: str) -> Sequence[str]:
        """Return every value of a header."""
        ...


@dataclass(frozen=True)
class Guard:
    """Judges requests to a server bound to `host`; `token` None means that none is asked for."""

    host: str
    token: str | None = None

    @property
    def opened(self) -> bool:
        """Whether others than this machine can reach the server."""
        return not is_loopback(self.host)

    def refusal(self, target: str, headers: Headers) -> str | None:
        """Return why a request for `target` (path and query) is refused, None if it is not."""
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        name = _hostname(hosts[0]) if len(hosts) == 1 else None
        if name is None or not self._answers_to(name):
            return "foreign Host"
        websocket = any(value.lower() == "websocket" for value in headers.get_all("Upgrade"))
        if len(origins) > 1 or (websocket and not origins):
            return "missing Origin"
        if origins and not _same_place(origins[0], hosts[0]):
            return "foreign Origin"
        if self.token is not None and not self._knows_token(target, headers):
            return "wrong or missing token"
        return None

    def presented_token(self, target: str) -> bool:
        """Return whether the right token stands in the address itself."""
        given = parse_qs(urlsplit(target).query).get("token", [])
        return self.token is not None and len(given) == 1 and _equal(given[0], self.token)

    def _answers_to(self, name: str) -> bool:
        if name in LOOPBACK_NAMES:
            return True
        # An address as a name cannot be rebound; a token protects it.
        return self.opened and (_is_address(name) or name == socket.gethostname().lower())

    def _knows_token(self, target: str, headers: Headers) -> bool:
        if self.presented_token(target):
            return True
        for header in headers.get_all("Cookie"):
            try:
                morsel = SimpleCookie(header).get(COOKIE)
            except CookieError:
                continue
            if morsel is not None and self.token is not None and _equal(morsel.value, self.token):
                return True
        return False


def make_guard(host: str) -> Guard:
    """Return the guard of a server bound to `host`, with a fresh token unless it is loopback."""
    return Guard(host, None if is_loopback(host) else secrets.token_urlsafe(24))


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach a server bound to `host`."""
    if host == "localhost":
        return True
    return _is_address(host) and ipaddress.ip_address(host).is_loopback


def _equal(given: str, wanted: str) -> bool:
    return hmac.compare_digest(given.encode(), wanted.encode())


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _hostname(netloc: str) -> str | None:
    try:
        parts = urlsplit(f"//{netloc}")
        name, _ = parts.hostname, parts.port
    except ValueError:
        return None
    plain = parts.netloc == netloc and "@" not in netloc
    return name if plain else None


def _same_place(origin: str, host: str) -> bool:
    try:
        parts = urlsplit(origin)
    except ValueError:
        return False
    return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()
