"""The server of a page: its files, its pictures, and the browsers that show it."""

from __future__ import annotations

import asyncio
import errno
from collections.abc import Callable, Coroutine, Iterable, Mapping
from pathlib import Path
from typing import Any, Generic, TypeVar

from aiohttp import web

from vidstyle.errors import OutputError, StyleError
from vidstyle.export import SCRIPT_FOLDERS
from vidstyle.web.background_tasks import BackgroundTasks
from vidstyle.web.connection import PageConnection
from vidstyle.web.server import Handler, WebServer

Connection = TypeVar("Connection", bound=PageConnection)


class PageServer(Generic[Connection]):
    """Serves one page to a limited number of browsers. All coroutines run in its event loop.

    Attributes:
        url, one_time_url: see `WebServer`.
        browsers: the connections that are open.
        tasks: background tasks that continue when browsers disconnect.
    """

    def __init__(
        self,
        subject: str,
        connect: Callable[[], Connection],
        handlers: Mapping[str, Handler],
        static: Path,
        index: str,
        *,
        most: int,
        port: int = 0,
        address: str | None = None,
    ) -> None:
        """Start serving.

        Args:
            subject: the subject of errors, and the name of the thread.
            connect: makes the connection for a new browser, in the event loop.
            handlers, index, port, address: see `WebServer`.
            static: the folder of the files of this page.
            most: maximum number of browsers.

        Raises:
            OutputError: the port is taken or needs privileges, or the address is not one of this machine.
        """
        self.browsers: list[Connection] = []
        self._connect, self._most = connect, most
        self._fault: BaseException | None = None
        self.tasks = BackgroundTasks(self.fail)
        handlers = {"/socket": self._serve_socket, **handlers}
        try:
            self._server = WebServer(
                f"vidstyle {subject}", handlers, [*SCRIPT_FOLDERS, static], index, port, address
            )
        except OSError as error:
            raise _not_available(subject, port, address, error) from error
        self.url, self.one_time_url = self._server.url, self._server.one_time_url

    @property
    def error(self) -> BaseException | None:
        """The exception that ended the server (a bug in this program), or None."""
        return self._fault or self._server.error

    def fail(self, error: BaseException) -> None:
        """Report an exception in a background task."""
        self._fault = error

    def submit(self, function: Callable[..., Coroutine[Any, Any, None]], *values: object) -> None:
        """Run a coroutine function in the thread of the server; ignored after `close`."""
        self._server.submit(function, *values)

    async def tell(self, message: dict[str, Any]) -> None:
        """Send a message to all browsers."""
        for browser in list(self.browsers):
            await browser.tell(message)

    def close(self) -> None:
        """Cancel background tasks, disconnect all browsers, and stop."""
        self._server.submit(self.tasks.cancel)
        self._server.close()

    async def _serve_socket(self, request: web.Request) -> web.StreamResponse:
        return await self._server.serve(request, self._connect(), self.browsers, self._most)


def named_pictures(
    names: Callable[[], Iterable[str]], make: Callable[[str], Coroutine[Any, Any, bytes]]
) -> Handler:
    """Return a handler for the JPEG picture of each name; it is made once, at the first request "?of=NAME".

    Unknown names, and names whose style is invalid, give 404.
    """
    made: dict[str, asyncio.Future[bytes]] = {}

    async def handler(request: web.Request) -> web.StreamResponse:
        name = request.query.get("of", "")
        if name not in names():
            raise web.HTTPNotFound
        if name not in made:
            made[name] = asyncio.ensure_future(make(name))
        try:
            return jpeg_response(await asyncio.shield(made[name]))
        except StyleError as error:  # an invalid style file of the user
            raise web.HTTPNotFound from error

    return handler


def jpeg_response(data: bytes) -> web.Response:
    """Return a JPEG picture as a response."""
    return web.Response(body=data, content_type="image/jpeg")


def _not_available(subject: str, port: int, address: str | None, error: OSError) -> OutputError:
    if error.errno == errno.EADDRNOTAVAIL:
        return OutputError(
            subject,
            f"{address} is not an address of this machine",
            "give one with --host, or 0.0.0.0 for all",
        )
    return OutputError(subject, f"port {port}: {error.strerror or error}", "give another with --port")
