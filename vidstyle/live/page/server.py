"""The server behind the page: plain requests and sockets on one port of this machine."""

from __future__ import annotations

import asyncio
import logging
from http import HTTPStatus

from websockets.asyncio.server import ServerConnection, serve
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from vidstyle.live.page import answers
from vidstyle.live.page.auth import NAMES, Authorization, RefusedError
from vidstyle.live.page.hub import FrameHub
from vidstyle.live.page.viewer import Viewer

MAX_VIEWERS = 4
MAX_MESSAGE = 1 << 16
OPEN_SECONDS, CLOSE_SECONDS = 5.0, 1.0

_quiet = logging.getLogger("vidstyle.live.page.server")
# What strangers send is no news for the terminal.
_quiet.addHandler(logging.NullHandler())
_quiet.propagate = False


class Server:
    """Lives in one loop; every method is called from there.

    Attributes:
        exhibit: what browsers are shown.
        address: where to find the page, secret included; once `open`.
        error: why a browser could not be served, which is a fault of ours, or None.
    """

    def __init__(self, exhibit: FrameHub) -> None:
        self.exhibit = exhibit
        self.address = ""
        self.error: BaseException | None = None

    async def open(self, port: int) -> None:
        """Begin to listen; raises OSError if the port is not to be had."""
        self._server = await serve(
            self._view, NAMES[0], port, process_request=self._receive, compression=None, server_header=None,
            max_size=MAX_MESSAGE, max_queue=8, open_timeout=OPEN_SECONDS, close_timeout=CLOSE_SECONDS,
            logger=_quiet,
        )  # fmt: skip
        port = next(iter(self._server.sockets)).getsockname()[1]
        self._admission = Authorization(port)
        self.address = f"http://{NAMES[0]}:{port}/?token={self._admission.token}"

    async def close(self) -> None:
        """Tell all browsers that it is over, and stop."""
        self._server.close()
        await self._server.wait_closed()
        self.exhibit.close()

    async def _receive(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer a plain request, or None for one that becomes a socket."""
        try:
            return await self._respond(request)
        except RefusedError as error:
            return answers.refusal(error.status, str(error))

    async def _respond(self, request: Request) -> Response | None:
        self._admission.check_sender(request.path, request.headers)
        if self._admission.brings_token(request.path):
            return answers.to_page(self._admission.cookie)
        self._admission.check_cookie(request.headers)
        path = request.path.partition("?")[0]
        if path == answers.SOCKET:
            if len(self.exhibit.viewers) >= MAX_VIEWERS:
                raise RefusedError(HTTPStatus.TOO_MANY_REQUESTS, f"{MAX_VIEWERS} browsers look at it already")
            return None
        if path == answers.PICTURE and (picture := await self.exhibit.png()):
            name, data = picture
            return answers.download(data, name)
        found = answers.page_file(path, request.headers["Host"])
        if found is None:
            raise RefusedError(HTTPStatus.NOT_FOUND, "there is nothing of that name")
        return found

    async def _view(self, socket: ServerConnection) -> None:
        exhibit = self.exhibit
        if len(exhibit.viewers) >= MAX_VIEWERS:  # several came at once
            await socket.close(CloseCode.TRY_AGAIN_LATER, "too many browsers")
            return
        viewer = Viewer(socket, exhibit)
        exhibit.viewers.add(viewer)
        try:
            await viewer.serve()
        except asyncio.CancelledError:
            raise
        except BaseException as error:  # raised again in the session's own thread
            self.error = error
        finally:
            exhibit.leave(viewer)
