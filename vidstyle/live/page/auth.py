"""Who may ask the page's server for anything: only a browser on this machine that was given the address.

Any site that the browser shows can send requests to this machine, and its own name may point here. So the
name of the host, the origin and a secret are all looked at, for pages and sockets alike.
"""

from __future__ import annotations

import hmac
import secrets
from http import HTTPStatus
from urllib.parse import parse_qs

from websockets.datastructures import Headers

NAMES = ("127.0.0.1", "localhost")
"""What the server may be called by; it listens on the first."""


class RefusedError(Exception):
    """A request that is not let in, with the status that it gets."""

    def __init__(self, status: HTTPStatus, reason: str) -> None:
        self.status = status
        super().__init__(reason)


class Authorization:
    """Looks at requests before anything is done for them.

    Attributes:
        token: the secret in the address that is printed.
        cookie: the cookie by which a browser shows that it knows the secret, as "name=value".
    """

    def __init__(self, port: int) -> None:
        self.token = secrets.token_urlsafe(24)
        # Cookies are shared by all ports of a host: two sessions must not overwrite each other's.
        self._cookie_name = f"vidstyle-{port}"
        self.cookie = f"{self._cookie_name}={self.token}"
        self._hosts = tuple(f"{name}:{port}" for name in NAMES)

    def check_sender(self, path: str, headers: Headers) -> None:
        """Refuse what another site, or this one by another name, has sent.

        Raises:
            RefusedError: a Host or Origin that is not ours, or a request that another site has made.
        """
        if len(headers.get_all("Host")) != 1 or headers["Host"] not in self._hosts:
            raise RefusedError(HTTPStatus.FORBIDDEN, "this server is not called that")
        if any(origin != f"http://{headers['Host']}" for origin in headers.get_all("Origin")):
            raise RefusedError(HTTPStatus.FORBIDDEN, "another site asks for this")
        sites = headers.get_all("Sec-Fetch-Site")
        if any(site not in ("same-origin", "none") for site in sites) and not _is_visit(path, headers):
            raise RefusedError(HTTPStatus.FORBIDDEN, "another site asks for this")

    def brings_token(self, path: str) -> bool:
        """Whether the address is the one that was printed, secret included."""
        tokens = parse_qs(path.partition("?")[2]).get("token", [])
        return path.startswith("/?") and len(tokens) == 1 and self._is_token(tokens[0])

    def check_cookie(self, headers: Headers) -> None:
        """Refuse those who were not given the address.

        Raises:
            RefusedError: the secret is missing or wrong.
        """
        pairs = [pair.strip().partition("=") for pair in ";".join(headers.get_all("Cookie")).split(";")]
        given = [value for name, _, value in pairs if name == self._cookie_name]
        if len(given) != 1 or not self._is_token(given[0]):
            raise RefusedError(HTTPStatus.FORBIDDEN, "open the address that vidstyle has printed")

    def _is_token(self, text: str) -> bool:
        return hmac.compare_digest(text.encode("utf-8", "surrogatepass"), self.token.encode())


def _is_visit(path: str, headers: Headers) -> bool:
    """Whether somebody follows a link to the page itself, in a window of its own."""
    return (
        path.partition("?")[0] == "/"
        and headers.get_all("Sec-Fetch-Mode") == ["navigate"]
        and headers.get_all("Sec-Fetch-Dest") == ["document"]
    )
