"""A web server on one port of this machine, running in a thread of its own."""

from __future__ import annotations

import asyncio
import hmac
import logging
import secrets
import threading
import weakref
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from aiohttp import WSCloseCode, web

HOSTS = ("127.0.0.1", "localhost")
"""Accepted host names; the server binds to the first."""
MAX_MESSAGE = 1 << 16
"""Bytes of the largest WebSocket message that is accepted."""
OPEN_SECONDS, CLOSE_SECONDS = 5.0, 1.0
"""Time that a client has to send its request, and that closing a connection may take."""
HEARTBEAT_SECONDS = 20.0

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""What the page may load; the server adds its own WebSockets."""
SECURITY_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}

_quiet = logging.getLogger("vidstyle.web")
# Malformed requests are not shown in the terminal.
_quiet.disabled = True


class WebServer:
    """Serves handlers and static files to browsers that were given the address (see `Authorization`).

    Requests are GET without a body; every response has headers that confine the page to this server.

    Attributes:
        url: address of the page, including the token.
        error: the exception that a handler failed with, a fault of this program, or None.
    """

    def __init__(
        self, name: str, handlers: Mapping[str, Handler], static: Path, index: str, port: int = 0
    ) -> None:
        """Start listening.

        Args:
            name: of the thread.
            handlers: by path.
            static: folder whose files are served by their names.
            index: the file in it that is served as "/".
            port: 0 chooses a free one.

        Raises:
            OSError: the port is not available.
        """
        self.error: BaseException | None = None
        self._sockets: weakref.WeakSet[web.WebSocketResponse] = weakref.WeakSet()
        self._silent: dict[web.RequestHandler, asyncio.TimerHandle] = {}
        self._loop = asyncio.new_event_loop()
        app = web.Application(middlewares=[self._guard])
        app.on_response_prepare.append(self._add_headers)
        files = {
            "/" if file.name == index else f"/{file.name}": partial(_send, file) for file in static.iterdir()
        }
        for path, handler in (files | dict(handlers)).items():
            app.router.add_get(path, handler, allow_head=False)
        self._runner = web.AppRunner(
            app, access_log=None, logger=_quiet, keepalive_timeout=OPEN_SECONDS, lingering_time=0,
            shutdown_timeout=CLOSE_SECONDS,
        )  # fmt: skip
        try:
            port = self._loop.run_until_complete(self._listen(port))
        except OSError:
            self._loop.run_until_complete(self._runner.cleanup())
            self._loop.close()
            raise
        self._authorization = Authorization(port)
        # Not every browser lets 'self' stand for WebSockets too.
        sockets = " ".join(f"ws://{host}:{port}" for host in HOSTS)
        policy = f"{POLICY}; connect-src 'self' {sockets}"
        self._headers = SECURITY_HEADERS | {"Content-Security-Policy": policy}
        self.url = f"http://{HOSTS[0]}:{port}/?token={self._authorization.token}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, function: Callable[..., Coroutine[Any, Any, None]], *args: object) -> None:
        """Run a coroutine function in the server's thread; after `close` nothing happens."""
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(lambda: self._loop.create_task(function(*args)))

    async def accept(self, request: web.Request) -> web.WebSocketResponse:
        """Accept a WebSocket handshake; the server closes the socket when it is closed itself.

        Raises:
            web.HTTPUpgradeRequired: the request is none.
        """
        socket = web.WebSocketResponse(
            max_msg_size=MAX_MESSAGE, compress=False, heartbeat=HEARTBEAT_SECONDS, timeout=CLOSE_SECONDS
        )
        if not socket.can_prepare(request):
            raise web.HTTPUpgradeRequired(headers={"Upgrade": "websocket"})
        self._sockets.add(socket)
        await socket.prepare(request)
        return socket

    def close(self) -> None:
        """Close all WebSockets with code 1001 (going away) and stop."""
        if self._thread.is_alive():
            self.submit(self._end)
            self._thread.join(3 * CLOSE_SECONDS)

    async def _listen(self, port: int) -> int:
        await self._runner.setup()
        self._listener = await self._loop.create_server(self._connect, HOSTS[0], port)
        return int(self._listener.sockets[0].getsockname()[1])

    def _connect(self) -> asyncio.BaseProtocol:
        """The protocol of a new connection; aiohttp itself would wait for its first request without limit."""
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
        if request.can_read_body:
            raise web.HTTPBadRequest(text="400: no request here has a body\n")
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
        response.headers.update(self._headers)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_forever()
        finally:
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
            self._loop.close()

    async def _end(self) -> None:
        self._listener.close()
        closing = (socket.close(code=WSCloseCode.GOING_AWAY) for socket in list(self._sockets))
        await asyncio.gather(*closing, return_exceptions=True)
        await self._runner.cleanup()
        self._loop.stop()


async def _send(path: Path, request: web.Request) -> web.StreamResponse:
    return web.FileResponse(path)


class Authorization:
    """Admits only a browser on this machine that was given the address.

    Any web site can make the browser send requests to this machine, and any host name can be made to resolve
    to it. Host, Origin and a secret token are therefore checked for every request, WebSocket handshakes
    included.

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
        is_cross_site = set(_values(request, "Sec-Fetch-Site")) - {"same-origin", "none"}
        # Somebody may follow a link to the page itself, in a window of its own.
        fetch = [_values(request, f"Sec-Fetch-{name}") for name in ("Mode", "Dest")]
        is_navigation = request.path == "/" and fetch == [["navigate"], ["document"]]
        if is_foreign or (is_cross_site and not is_navigation):
            raise web.HTTPForbidden(text="403: cross-site request\n")

    def _is_token(self, values: list[str]) -> bool:
        texts = [value.encode("utf-8", "surrogatepass") for value in values]
        return len(texts) == 1 and hmac.compare_digest(texts[0], self.token.encode())


def _values(request: web.BaseRequest, name: str) -> list[str]:
    return request.headers.getall(name, [])
