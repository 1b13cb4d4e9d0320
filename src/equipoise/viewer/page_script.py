"""The scripts that are added to viser's page, see the files of their `NAMES`."""

from __future__ import annotations

from pathlib import Path

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

PAGES = ("/", "/index.html")
END = b"</body>"
NAMES = (
    "software_drawing.js",
    "number_boxes.js",
    "narrow_page.js",
    "phone_page.js",
    "stick_pad.js",
)
SCRIPTS = tuple(Path(__file__).parent / "files" / name for name in NAMES)


def asks_for_page(request: Request) -> bool:
    """Return whether a request is for the page, and see to it that the answer can be changed."""
    if request.path.partition("?")[0] not in PAGES or "Upgrade" in request.headers:
        return False
    if "Accept-Encoding" in request.headers:
        del request.headers["Accept-Encoding"]
    return True


def with_script(response: Response) -> Response:
    """Return the response with the scripts at the end of its page; as it is where that has none."""
    page, end, rest = (response.body or b"").rpartition(END)
    if not end:
        return response
    script = b"".join(b"<script>" + path.read_bytes() + b"</script>" for path in SCRIPTS)
    headers = Headers(response.headers)
    body = page + script + end + rest
    if "Content-Length" in headers:
        del headers["Content-Length"]
    headers["Content-Length"] = str(len(body))
    return Response(response.status_code, response.reason_phrase, headers, body)
