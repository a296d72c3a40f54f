"""The server behind the page: plain requests and sockets on one port of this machine."""

from __future__ import annotations

import asyncio
import dataclasses
import logging
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from vidstyle.live.control import Controls
from vidstyle.live.meter import Meter
from vidstyle.live.page import answers
from vidstyle.live.page.admission import NAMES, Admission, RefusedError
from vidstyle.live.page.news import News
from vidstyle.live.page.panel import panel
from vidstyle.live.page.pictures import jpeg, png
from vidstyle.live.page.viewer import Viewer
from vidstyle.live.target import LiveFrame
from vidstyle.style import Style

MOST_VIEWERS = 4
LARGEST_MESSAGE = 1 << 16
OPEN_SECONDS, CLOSE_SECONDS = 5.0, 1.0

_quiet = logging.getLogger("vidstyle.live.page.server")
# What strangers send is no news for the terminal.
_quiet.addHandler(logging.NullHandler())
_quiet.propagate = False


class Server:
    """Lives in one loop; every method but those that say otherwise is called from there.

    Attributes:
        controls: of the session.
        changed: told whenever a wish was carried out.
        address: where to find the page, secret included; once `open`.
        delivered, dropped: frames that some browser has shown, and those left out for newer ones.
        viewers: how many browsers there are.
        bypasser: the browser that bypasses the style; when it goes, the bypass ends.
        error: why one could not be served, which is a fault of ours, or None.
    """

    def __init__(self, controls: Controls, meter: Meter) -> None:
        self.controls, self._meter = controls, meter
        self.changed, self._fresh = News(), News()
        self.delivered = self.dropped = 0
        self.address = ""
        self.error: BaseException | None = None
        self.bypasser: Viewer | None = None
        self._viewers: set[Viewer] = set()
        self._latest: LiveFrame | None = None
        self._taken: LiveFrame | None = None
        self._counted = -1
        self._jpegs: dict[int, asyncio.Future[bytes]] = {}
        self._starts: dict[str, Style] = {}
        self._worker = ThreadPoolExecutor(1, "vidstyle page pictures")

    @property
    def viewers(self) -> int:
        """See the class."""
        return len(self._viewers)

    async def open(self, port: int) -> None:
        """Begin to listen; raises OSError if the port is not to be had."""
        self._server = await serve(
            self._view, NAMES[0], port, process_request=self._receive, compression=None, server_header=None,
            max_size=LARGEST_MESSAGE, max_queue=8, open_timeout=OPEN_SECONDS, close_timeout=CLOSE_SECONDS,
            logger=_quiet,
        )  # fmt: skip
        port = next(iter(self._server.sockets)).getsockname()[1]
        self._admission = Admission(port)
        self.address = f"http://{NAMES[0]}:{port}/?token={self._admission.token}"

    async def close(self) -> None:
        """Tell all browsers that it is over, and stop."""
        self._server.close()
        await self._server.wait_closed()
        self._worker.shutdown(wait=False)

    def show(self, frame: LiveFrame) -> None:
        """The newest frame."""
        self.dropped += self.viewers > 0 and self._latest is not None and self._latest is not self._taken
        self._latest = frame
        self._jpegs.clear()
        self._fresh.tell()

    def count(self, frame: LiveFrame) -> None:
        """A browser has shown this frame."""
        if frame.number > self._counted:
            self._counted = frame.number
            self.delivered += 1
            self._meter.delivered(frame.captured)

    async def newer(self, frame: LiveFrame | None) -> LiveFrame:
        """The newest frame, as soon as it is another than this."""
        while self._latest is None or self._latest is frame:
            await self._fresh.wait()
        self._taken = self._latest
        return self._latest

    async def jpeg(self, frame: LiveFrame, quality: int) -> bytes:
        """The frame as JPEG, made once for all who want it alike."""
        if frame is not self._latest:
            return await self._work(jpeg, frame, quality)
        if quality not in self._jpegs:
            self._jpegs[quality] = asyncio.ensure_future(self._work(jpeg, frame, quality))
        return await asyncio.shield(self._jpegs[quality])

    async def panel(self, style: Style) -> dict[str, Any]:
        """What can be set on the style."""
        if style.name not in self._starts:
            self._starts[style.name] = self.controls.without_variant(style.name)
        return await asyncio.to_thread(panel, style, self._starts[style.name])

    def status(self) -> dict[str, Any]:
        """How the session is."""
        return dataclasses.asdict(self.controls.status())

    async def _work(self, function: Any, *values: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._worker, function, *values)

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
            if self.viewers >= MOST_VIEWERS:
                raise RefusedError(
                    HTTPStatus.TOO_MANY_REQUESTS, f"{MOST_VIEWERS} browsers look at it already"
                )
            return None
        if path == answers.PICTURE and self._latest is not None:
            name = f"vidstyle-{self.controls.style_name.replace(':', '-')}-{self._latest.number}.png"
            return answers.download(await self._work(png, self._latest), name)
        found = answers.page_file(path, request.headers["Host"])
        if found is None:
            raise RefusedError(HTTPStatus.NOT_FOUND, "there is nothing of that name")
        return found

    async def _view(self, socket: ServerConnection) -> None:
        if self.viewers >= MOST_VIEWERS:  # several came at once
            await socket.close(CloseCode.TRY_AGAIN_LATER, "too many browsers")
            return
        viewer = Viewer(socket, self)
        self._viewers.add(viewer)
        try:
            await viewer.serve()
        except asyncio.CancelledError:
            raise
        except BaseException as error:  # raised again in the session's own thread
            self.error = error
        finally:
            self._viewers.discard(viewer)
            if self.bypasser is viewer:
                self.controls.bypass(False)
                self.bypasser = None
