"""Access control: only a browser on this machine that was given the address is served.

Any web site can make the browser send requests to this machine, and any host name can be made to resolve to
it. Host, Origin and a secret token are therefore checked for every request, WebSocket handshakes included.
"""

from __future__ import annotations

import hmac
import secrets

from aiohttp import web

HOSTS = ("127.0.0.1", "localhost")
"""Accepted host names; the server binds to the first."""


class Authorization:
    """Checks requests before they are handled.

    Attributes:
        token: the secret in the address that is printed.
        cookie: the cookie by which a browser proves that it knows the token, as "name=value".
    """

    def __init__(self, port: int) -> None:
        self.token = secrets.token_urlsafe(24)
        # Cookies are shared by all ports of a host: two servers must not overwrite each other's.
        self._cookie_name = f"vidstyle-{port}"
        self.cookie = f"{self._cookie_name}={self.token}"
        self._hosts = tuple(f"{name}:{port}" for name in HOSTS)

    def check(self, request: web.BaseRequest) -> None:
        """Let the request pass, or raise the response that it gets.

        Raises:
            web.HTTPSeeOther: the request has the token in its address; the browser is redirected to the
                address without it, which its history may keep, and gets the cookie instead.
            web.HTTPForbidden: foreign Host or Origin, a cross-site request, or no valid cookie.
        """
        self._check_sender(request)
        if request.path == "/" and self._is_token(request.query.getall("token", [])):
            cookie = f"{self.cookie}; HttpOnly; SameSite=Strict; Path=/"
            raise web.HTTPSeeOther("/", headers={"Set-Cookie": cookie})
        pairs = [pair.strip().partition("=") for pair in ";".join(_values(request, "Cookie")).split(";")]
        if not self._is_token([value for name, _, value in pairs if name == self._cookie_name]):
            raise web.HTTPForbidden(text="403: open the address that vidstyle has printed\n")

    def _check_sender(self, request: web.BaseRequest) -> None:
        hosts = _values(request, "Host")
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            raise web.HTTPForbidden(text="403: unknown host name\n")
        is_foreign = any(origin != f"http://{hosts[0]}" for origin in _values(request, "Origin"))
        sites = set(_values(request, "Sec-Fetch-Site"))
        if is_foreign or (sites - {"same-origin", "none"} and not _is_navigation(request)):
            raise web.HTTPForbidden(text="403: cross-site request\n")

    def _is_token(self, values: list[str]) -> bool:
        texts = [value.encode("utf-8", "surrogatepass") for value in values]
        return len(texts) == 1 and hmac.compare_digest(texts[0], self.token.encode())


def _is_navigation(request: web.BaseRequest) -> bool:
    """Whether somebody follows a link to the page itself, in a window of its own."""
    return (
        request.path == "/"
        and _values(request, "Sec-Fetch-Mode") == ["navigate"]
        and _values(request, "Sec-Fetch-Dest") == ["document"]
    )


def _values(request: web.BaseRequest, name: str) -> list[str]:
    return request.headers.getall(name, [])
