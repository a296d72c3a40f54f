"""What the page's server answers to plain requests: a few things that it holds, and refusals."""

from __future__ import annotations

import functools
from http import HTTPStatus
from pathlib import Path

from websockets.datastructures import Headers
from websockets.http11 import Response

FILES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
    "/icon.svg": ("icon.svg", "image/svg+xml"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
    "/panel.js": ("panel.js", "text/javascript; charset=utf-8"),
}
"""All that is ever read from the disk; what a request asks for is looked up here and nowhere else."""

PICTURE = "/picture.png"
SOCKET = "/socket"

CAREFUL = {
    "Cache-Control": "no-store",
    "Connection": "close",
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}


def policy(host: str) -> str:
    """What the page may load and where it may connect to: itself alone."""
    return (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
        f"connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


def answer(status: HTTPStatus, body: bytes, kind: str = "text/plain; charset=utf-8", **more: str) -> Response:
    """An answer with all headers that keep a browser from doing more with it; `more` with _ for -."""
    headers = CAREFUL | {name.replace("_", "-"): value for name, value in more.items()}
    headers |= {"Content-Type": kind, "Content-Length": str(len(body))}
    return Response(status.value, status.phrase, Headers(headers), body)


def refusal(status: HTTPStatus, reason: str) -> Response:
    """A refusal in one line."""
    return answer(status, f"{status.value} {status.phrase}: {reason}\n".encode())


def to_page(cookie: str) -> Response:
    """Sends a browser on to the page's address without the secret, which its history would keep."""
    kept = f"{cookie}; HttpOnly; SameSite=Strict; Path=/"
    return answer(HTTPStatus.SEE_OTHER, b"", Location="/", Set_Cookie=kept)


def page_file(path: str, host: str) -> Response | None:
    """One of FILES, or None if there is none of that name."""
    if path not in FILES:
        return None
    name, kind = FILES[path]
    return answer(HTTPStatus.OK, _read(name), kind, Content_Security_Policy=policy(host))


def download(png: bytes, name: str) -> Response:
    """A picture to be kept under this name."""
    return answer(HTTPStatus.OK, png, "image/png", Content_Disposition=f'attachment; filename="{name}"')


@functools.cache
def _read(name: str) -> bytes:
    return Path(__file__).with_name(name).read_bytes()
