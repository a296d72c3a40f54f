"""A web server on a local port, running in a separate thread."""

from __future__ import annotations

import asyncio
import hmac
import logging
import os
import secrets
import socket
import threading
import weakref
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, Protocol, TypeVar

from aiohttp import WSCloseCode, web

SHARED_FOLDER = Path(__file__).with_name("static")
"""Modules that every page may import."""
THIS_MACHINE, ANY_ADDRESS = "127.0.0.1", "0.0.0.0"
"""The loopback address, and the address that stands for all interfaces."""
MAX_MESSAGE = 1 << 16
"""Maximum size of a WebSocket message in bytes."""
OPEN_SECONDS, CLOSE_SECONDS = 5.0, 1.0
"""Time limits for a client to send its request, and for closing a connection."""
HEARTBEAT_SECONDS = 20.0

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class SocketViewer(Protocol):
    """A connection to one browser."""

    async def serve(self, socket: web.WebSocketResponse) -> None:
        """Send pictures and handle messages until the socket closes."""


Viewing = TypeVar("Viewing", bound=SocketViewer)

CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; media-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of the pages; the server adds its own WebSockets."""
DOCUMENT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Policy for documents of this program, which contain all their parts and allow their scripts by digest."""
SECURITY_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}

_quiet = logging.getLogger("vidstyle.web")
# Do not log malformed requests to the terminal.
_quiet.disabled = True


class WebServer:
    """Serves handlers and static files to browsers that were given the address (see `Authorization`).

    Requests are GET without a body; every response has headers that confine the page to this server.

    Attributes:
        url: address of the page, including the token.
        one_time_url: an address that admits one browser, the first: other users of this machine see it in
            the command line of the browser that opens it.
        error: the exception raised by a handler (a bug in this program), or None.
    """

    def __init__(
        self,
        name: str,
        handlers: Mapping[str, Handler],
        static: Sequence[Path],
        index: str,
        port: int = 0,
        address: str | None = None,
    ) -> None:
        """Start listening.

        Args:
            name: of the thread.
            handlers: by path.
            static: files and folders to serve by file name, in addition to `SHARED_FOLDER`.
            index: the name of the file to serve as "/".
            port: 0 selects a free one.
            address: the IPv4 address to listen on; `ANY_ADDRESS` for all interfaces; None for loopback only.

        Raises:
            OSError: the port or the address is not available.
        """
        self.error: BaseException | None = None
        self._sockets: weakref.WeakSet[web.WebSocketResponse] = weakref.WeakSet()
        self._silent: dict[web.RequestHandler, asyncio.TimerHandle] = {}
        self._loop = asyncio.new_event_loop()
        app = web.Application(middlewares=[self._guard])
        app.on_response_prepare.append(self._add_headers)
        found = [
            file
            for path in (SHARED_FOLDER, *static)
            for file in (path.iterdir() if path.is_dir() else [path])
        ]
        files = {"/" if file.name == index else f"/{file.name}": partial(_send, file) for file in found}
        for path, handler in (files | dict(handlers)).items():
            app.router.add_get(path, handler, allow_head=False)
        self._runner = web.AppRunner(
            app, access_log=None, logger=_quiet, keepalive_timeout=OPEN_SECONDS, lingering_time=0,
            shutdown_timeout=CLOSE_SECONDS,
        )  # fmt: skip
        try:
            port = self._loop.run_until_complete(self._listen(address or THIS_MACHINE, port))
        except OSError:
            self._loop.run_until_complete(self._runner.cleanup())
            self._loop.close()
            raise
        self._authorization = Authorization(port)
        shown = network_address() if address == ANY_ADDRESS else address or THIS_MACHINE
        self.url = f"http://{shown}:{port}/?token={self._authorization.token}"
        self.one_time_url = f"http://{shown}:{port}/?token={self._authorization.ticket}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, function: Callable[..., Coroutine[Any, Any, None]], *args: object) -> None:
        """Run a coroutine function in the thread of the server; ignored after `close`."""
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(lambda: self._loop.create_task(function(*args)))

    async def serve(
        self, request: web.Request, viewer: Viewing, viewers: list[Viewing], most: int
    ) -> web.WebSocketResponse:
        """Accept a WebSocket handshake, and have a viewer serve the socket until it closes.

        Args:
            request: the handshake.
            viewer: the new connection; it is in `viewers` while it is open.
            viewers: the open connections of the page.
            most: the maximum number of connections.

        Raises:
            web.HTTPForbidden: the handshake has no Origin.
            web.HTTPTooManyRequests: the maximum is reached.
            web.HTTPUpgradeRequired: the request is no handshake.
        """
        if len(viewers) >= most:
            raise web.HTTPTooManyRequests(text=f"429: {most} browsers already show the page\n")
        socket = await self._accept(request)
        viewers.append(viewer)
        try:
            await viewer.serve(socket)
        finally:
            viewers.remove(viewer)
        return socket

    async def _accept(self, request: web.Request) -> web.WebSocketResponse:
        socket = web.WebSocketResponse(
            max_msg_size=MAX_MESSAGE, compress=False, heartbeat=HEARTBEAT_SECONDS, timeout=CLOSE_SECONDS
        )
        if not socket.can_prepare(request):
            raise web.HTTPUpgradeRequired(headers={"Upgrade": "websocket"})
        if "Origin" not in request.headers:  # every browser sends it; `Authorization` has checked its value
            raise web.HTTPForbidden(text="403: a WebSocket needs an Origin\n")
        self._sockets.add(socket)
        await socket.prepare(request)
        return socket

    def close(self) -> None:
        """Close all WebSockets with code 1001 (going away) and stop."""
        if self._thread.is_alive():
            self.submit(self._end)
            self._thread.join(3 * CLOSE_SECONDS)

    async def _listen(self, address: str, port: int) -> int:
        await self._runner.setup()
        self._listener = await self._loop.create_server(self._connect, sock=_bound_socket(address, port))
        return int(self._listener.sockets[0].getsockname()[1])

    def _connect(self) -> asyncio.BaseProtocol:
        """Return the protocol of a new connection, with a time limit for its first request."""
        assert self._runner.server is not None
        protocol = self._runner.server()
        self._silent[protocol] = self._loop.call_later(OPEN_SECONDS, self._drop, protocol)
        return protocol

    def _drop(self, protocol: web.RequestHandler) -> None:
        del self._silent[protocol]
        if protocol.transport is not None:
            protocol.transport.abort()

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Check the request before it reaches the handler."""
        if timer := self._silent.pop(request.protocol, None):
            timer.cancel()
        if request.can_read_body or request.content_length or "Transfer-Encoding" in request.headers:
            raise web.HTTPBadRequest(text="400: requests must not have a body\n")
        self._authorization.check(request)
        if not request.raw_path.startswith("/") or "%" in request.raw_path.partition("?")[0]:
            raise web.HTTPNotFound
        try:
            return await handler(request)
        except Exception as error:
            if not isinstance(error, web.HTTPException | ConnectionError):
                self.error = error
            raise

    async def _add_headers(self, request: web.Request, response: web.StreamResponse) -> None:
        del response.headers["Server"]
        # Not every browser lets 'self' stand for WebSockets too.
        sockets = " ".join(f"ws://{host}" for host in own_hosts(request))
        policy = f"{CONTENT_POLICY}; connect-src 'self' {sockets}"
        response.headers.setdefault("Content-Security-Policy", policy)
        response.headers.update(SECURITY_HEADERS)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_forever()
        finally:
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
            self._loop.close()

    async def _end(self) -> None:
        # A connection accepted in this turn of the loop still needs the listener: without it, asyncio of
        # Python 3.11 never closes the connection.
        with suppress(NotImplementedError):  # on Windows
            for listening in self._listener.sockets:
                self._loop.remove_reader(listening.fileno())
        await asyncio.sleep(0)
        self._listener.close()
        closing = (socket.close(code=WSCloseCode.GOING_AWAY) for socket in list(self._sockets))
        await asyncio.gather(*closing, return_exceptions=True)
        await self._runner.cleanup()
        self._loop.stop()


async def _send(path: Path, request: web.Request) -> web.StreamResponse:
    return web.FileResponse(path)


def own_hosts(request: web.BaseRequest) -> tuple[str, ...]:
    """Return the valid values of Host: the local address of the connection; none once it is lost."""
    name = request.transport.get_extra_info("sockname") if request.transport else None
    if name is None:
        return ()
    address, port = name
    return (f"{address}:{port}", *([f"localhost:{port}"] if address == THIS_MACHINE else []))


def _bound_socket(address: str, port: int) -> socket.socket:
    """Bind a socket; asyncio of Python 3.13 raises errors without `errno` for foreign addresses."""
    try:
        return socket.create_server((address, port))
    except OSError as error:  # whose reason ends with the address
        raise OSError(error.errno, os.strerror(error.errno or 0)) from error


def network_address() -> str:
    """Return the LAN address, or 127.0.0.1 if there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # reserved for documentation; no packet is sent
            return str(probe.getsockname()[0])
        except OSError:
            return THIS_MACHINE


class Authorization:
    """Admits only a browser that was given the address.

    Any web site can make the browser send requests to this machine, and any host name can be made to resolve
    to it. Host, Origin and a secret token are therefore checked for every request, WebSocket handshakes
    included.

    Attributes:
        token: the secret in the address that is printed.
        ticket: a secret that replaces the token once.
        cookie: the cookie by which a browser proves that it knows the token, as "name=value".
    """

    def __init__(self, port: int) -> None:
        self.token, self.ticket = secrets.token_urlsafe(24), secrets.token_urlsafe(24)
        self._ticket: str | None = self.ticket
        # Cookies are shared by all ports of a host: two servers must not overwrite each other's.
        self._cookie_name = f"vidstyle-{port}"
        self.cookie = f"{self._cookie_name}={self.token}"

    def check(self, request: web.BaseRequest) -> None:
        """Return if the request is authorized; raise the error response otherwise.

        Raises:
            web.HTTPSeeOther: the request has the token in its address; the browser is redirected to the
                address without it, which its history may keep, and gets the cookie instead.
            web.HTTPForbidden: foreign Host or Origin, a cross-site request, or no valid cookie.
        """
        self._check_sender(request)
        if request.path == "/" and self._admits(request.query.getall("token", [])):
            cookie = f"{self.cookie}; HttpOnly; SameSite=Strict; Path=/"
            raise web.HTTPSeeOther("/", headers={"Set-Cookie": cookie})
        pairs = [pair.strip().partition("=") for pair in ";".join(_values(request, "Cookie")).split(";")]
        if not _is_one([value for name, _, value in pairs if name == self._cookie_name], self.token):
            raise web.HTTPForbidden(text="403: open the address printed by vidstyle\n")

    def _check_sender(self, request: web.BaseRequest) -> None:
        hosts = _values(request, "Host")
        if len(hosts) != 1 or hosts[0] not in own_hosts(request):
            raise web.HTTPForbidden(text="403: unknown host name\n")
        is_foreign = any(origin != f"http://{hosts[0]}" for origin in _values(request, "Origin"))
        is_cross_site = set(_values(request, "Sec-Fetch-Site")) - {"same-origin", "none"}
        # Links to the page itself, opened in a new window, are allowed.
        fetch = [_values(request, f"Sec-Fetch-{name}") for name in ("Mode", "Dest")]
        is_navigation = request.path == "/" and fetch == [["navigate"], ["document"]]
        if is_foreign or (is_cross_site and not is_navigation):
            raise web.HTTPForbidden(text="403: cross-site request\n")

    def _admits(self, values: list[str]) -> bool:
        if _is_one(values, self._ticket):
            self._ticket = None
            return True
        return _is_one(values, self.token)


def _is_one(values: list[str], secret: str | None) -> bool:
    texts = [value.encode("utf-8", "surrogatepass") for value in values]
    return secret is not None and len(texts) == 1 and hmac.compare_digest(texts[0], secret.encode())


def _values(request: web.BaseRequest, name: str) -> list[str]:
    return request.headers.getall(name, [])
