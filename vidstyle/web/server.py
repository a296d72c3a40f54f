"""A web server on one port of this machine, running in a thread of its own."""

from __future__ import annotations

import asyncio
import logging
import threading
import weakref
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from pathlib import Path
from typing import Any

from aiohttp import WSCloseCode, web

from vidstyle.web.auth import HOSTS, Authorization

MAX_MESSAGE = 1 << 16
"""Bytes of the largest WebSocket message that is accepted."""
OPEN_SECONDS, CLOSE_SECONDS = 5.0, 1.0
"""Time that a client has to send its request, and that closing a connection may take."""
HEARTBEAT_SECONDS = 20.0

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

_quiet = logging.getLogger("vidstyle.web")
# Malformed requests are no news for the terminal.
_quiet.addHandler(logging.NullHandler())
_quiet.propagate = False


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
        for path, handler in handlers.items():
            app.router.add_get(path, handler, allow_head=False)
        for file in static.iterdir():
            app.router.add_get(
                "/" if file.name == index else f"/{file.name}", _sender(file), allow_head=False
            )
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
        self._headers = _security_headers(port)
        self.url = f"http://{HOSTS[0]}:{port}/?token={self._authorization.token}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, function: Callable[..., Coroutine[Any, Any, None]], *args: object) -> None:
        """Run a coroutine function in the server's thread; after `close` nothing happens."""
        try:
            self._loop.call_soon_threadsafe(lambda: self._loop.create_task(function(*args)))
        except RuntimeError:  # the loop is closed
            pass

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
        except (web.HTTPException, ConnectionError):
            raise
        except Exception as error:
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


def _sender(path: Path) -> Handler:
    async def send(request: web.Request) -> web.StreamResponse:
        return web.FileResponse(path)

    return send


def _security_headers(port: int) -> dict[str, str]:
    # Not every browser lets 'self' stand for WebSockets too.
    sockets = " ".join(f"ws://{host}:{port}" for host in HOSTS)
    return {
        "Cache-Control": "no-store",
        "Content-Security-Policy": (
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
            f"connect-src 'self' {sockets}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        ),
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
        "X-Frame-Options": "DENY",
    }
