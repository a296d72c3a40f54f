"""The page as a target of a live session."""

from __future__ import annotations

import logging
from pathlib import Path

from aiohttp import web

from vidstyle.errors import OutputError
from vidstyle.live.control import Controls
from vidstyle.live.page.hub import FrameHub
from vidstyle.live.page.viewer import Viewer
from vidstyle.live.target import LiveFrame
from vidstyle.live.timing import LatencyMeter
from vidstyle.web import WebServer

MAX_VIEWERS = 4
STATIC = Path(__file__).with_name("static")

log = logging.getLogger("vidstyle")


class PageTarget:
    """A target (see `Target`): a web page for browsers on this machine.

    Attributes:
        url: address of the page, including the token that admits a browser.
    """

    name = "page"
    repeated = 0

    def __init__(self, controls: Controls, port: int = 0, meter: LatencyMeter | None = None) -> None:
        """Open the page and log its address.

        Args:
            controls: of the session.
            port: of this machine; 0 chooses a free one.
            meter: records the latency of each frame that a browser has shown.

        Raises:
            OutputError: the port is taken, or needs privileges.
        """
        self._hub = FrameHub(controls, meter or LatencyMeter())
        handlers = {"/picture.png": self._send_picture, "/socket": self._serve_socket}
        try:
            self._server = WebServer("vidstyle page", handlers, STATIC, "page.html", port)
        except OSError as error:
            self._hub.close()
            reason = error.strerror or str(error)
            raise OutputError("page", f"port {port}: {reason}", "give another with --port") from error
        self.url = self._server.url
        log.warning("page: %s", self.url)

    @property
    def state(self) -> str:
        """The number of browsers that show the page, in words."""
        viewers = len(self._hub.viewers)
        return f"{viewers} browser{'s' * (viewers != 1)}" if viewers else "no browser"

    @property
    def error(self) -> BaseException | None:
        """The exception that ended the page, a fault of this program, or None."""
        return self._server.error

    @property
    def delivered(self) -> int:
        """Number of frames that a browser has shown."""
        return self._hub.delivered

    @property
    def dropped(self) -> int:
        """Number of frames that no browser was sent because a newer one was there."""
        return self._hub.dropped

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        self._server.submit(self._hub.show, frame)

    def close(self) -> None:
        """See Target."""
        self._server.close()
        self._hub.close()

    async def _send_picture(self, request: web.Request) -> web.StreamResponse:
        picture = await self._hub.png()
        if picture is None:
            raise web.HTTPNotFound
        name, data = picture
        headers = {"Content-Disposition": f'attachment; filename="{name}"'}
        return web.Response(body=data, content_type="image/png", headers=headers)

    async def _serve_socket(self, request: web.Request) -> web.StreamResponse:
        if len(self._hub.viewers) >= MAX_VIEWERS:
            raise web.HTTPTooManyRequests(text=f"429: {MAX_VIEWERS} browsers show the page already\n")
        viewer = Viewer(self._hub)
        self._hub.viewers.add(viewer)
        try:
            socket = await self._server.accept(request)
            await viewer.serve(socket)
        finally:
            self._hub.leave(viewer)
        return socket
