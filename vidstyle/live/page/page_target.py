"""The page as a target of a live session: the newest frame, encoded once for all browsers."""

from __future__ import annotations

import asyncio
import errno
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from aiohttp import web

from vidstyle.errors import OutputError, StyleError, log
from vidstyle.gallery.style_samples import encoded
from vidstyle.gallery.thumbnail import thumbnail
from vidstyle.live.control import Controls
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.page.viewer import Viewer
from vidstyle.live.target import LiveFrame
from vidstyle.style import Style
from vidstyle.style.panel import panel
from vidstyle.web import WebServer

MAX_VIEWERS = 4
STATIC_FOLDER = Path(__file__).with_name("static")


class PageTarget:
    """A target (see `Target`): a web page for browsers on this machine, or in its network.

    All coroutines run in the server's event loop.

    Attributes:
        url: the URL of the page, with its access token.
        controls, meter: of the session.
        changed: notified whenever a message was dispatched.
        delivered, dropped: number of frames that a browser has shown, and that none was sent.
        viewers: the browsers that are connected.
        bypasser: the one of them that bypasses the style; the bypass ends when it disconnects.
    """

    name = "page"
    repeated = 0

    def __init__(
        self,
        controls: Controls,
        port: int = 0,
        meter: LatencyMeter | None = None,
        address: str | None = None,
        browse: Callable[[str], None] | None = None,
    ) -> None:
        """Open the page and log its address.

        Args:
            controls: of the session.
            port: port to listen on; 0 selects a free one.
            meter: records the latency of each frame that a browser has shown, and has the page's clock.
            address: of this machine in its network; None: the page is for this machine only.
            browse: opens a one-time URL of the page in a browser.

        Raises:
            OutputError: the port is taken or needs privileges, or the address is not one of this machine.
        """
        self.controls, self.meter = controls, meter or LatencyMeter()
        self.changed, self._arrived = asyncio.Condition(), asyncio.Condition()
        self.delivered = self.dropped = 0
        self.viewers: list[Viewer] = []
        self.bypasser: Viewer | None = None
        self._latest: LiveFrame | None = None
        self._sent: LiveFrame | None = None
        self._counted = -1
        self._jpegs: dict[int, asyncio.Future[bytes]] = {}
        self._initial_styles: dict[str, Style] = {}
        self._encoder = ThreadPoolExecutor(1, "vidstyle page pictures")
        self._thumbnails: dict[str, asyncio.Future[bytes]] = {}
        handlers = {
            "/picture.png": self._send_picture,
            "/thumbnail.jpg": self._send_thumbnail,
            "/socket": self._serve_socket,
        }
        try:
            self._server = WebServer("vidstyle page", handlers, [STATIC_FOLDER], "page.html", port, address)
        except OSError as error:
            if error.errno == errno.EADDRNOTAVAIL:
                remedy = "give one with --host, or 0.0.0.0 for all"
                raise OutputError("page", f"{address} is no address of this machine", remedy) from error
            reason = error.strerror or str(error)
            raise OutputError("page", f"port {port}: {reason}", "give another with --port") from error
        self.url = self._server.url
        log.warning("page: %s", self.url)
        if address is not None:
            log.warning(
                "page: whoever in this network has its address can watch and steer; it is not encrypted"
            )
        if browse is not None:
            browse(self._server.one_time_url)

    @property
    def state(self) -> str:
        """The number of browsers that show the page, in words."""
        viewers = len(self.viewers)
        return f"{viewers} browser{'s' * (viewers != 1)}" if viewers else "no browser"

    @property
    def error(self) -> BaseException | None:
        """The exception that ended the page, a fault of this program, or None."""
        return self._server.error

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        self._server.submit(self._show, frame)

    def close(self) -> None:
        """See Target."""
        self._server.close()
        self._encoder.shutdown(wait=False)

    async def _show(self, frame: LiveFrame) -> None:
        """Make this the newest frame."""
        async with self._arrived:
            self.dropped += bool(self.viewers) and self._latest is not self._sent
            self._latest = frame
            self._jpegs.clear()
            self._arrived.notify_all()

    def count(self, frame: LiveFrame) -> None:
        """Count a frame that a browser has shown, once for all browsers."""
        if frame.number > self._counted:
            self._counted = frame.number
            self.delivered += 1
            self.meter.record(frame.captured)

    async def newer(self, frame: LiveFrame | None) -> LiveFrame:
        """Wait until the newest frame is another than this, and return it."""
        async with self._arrived:
            await self._arrived.wait_for(lambda: self._latest is not frame)
        assert self._latest is not None
        self._sent = self._latest
        return self._latest

    async def jpeg(self, frame: LiveFrame, quality: int) -> bytes:
        """The frame as JPEG, encoded once for each quality."""
        if frame is not self._latest:
            return await self._encode(encode_jpeg, frame, quality)
        if quality not in self._jpegs:
            self._jpegs[quality] = asyncio.ensure_future(self._encode(encode_jpeg, frame, quality))
        return await asyncio.shield(self._jpegs[quality])

    async def panel(self, style: Style) -> dict[str, Any]:
        """All parameters of the style, see `panel`."""
        if style.name not in self._initial_styles:
            self._initial_styles[style.name] = self.controls.without_variant(style.name)
        return await asyncio.to_thread(panel, style, self._initial_styles[style.name])

    async def _send_picture(self, request: web.Request) -> web.StreamResponse:
        frame = self._latest
        if frame is None:
            raise web.HTTPNotFound
        name = f"vidstyle-{self.controls.style.name.replace(':', '-')}-{frame.number}.png"
        data = await self._encode(encode_png, frame)
        headers = {"Content-Disposition": f'attachment; filename="{name}"'}
        return web.Response(body=data, content_type="image/png", headers=headers)

    async def _send_thumbnail(self, request: web.Request) -> web.StreamResponse:
        name = request.query.get("of", "")
        if name not in self.controls.names:
            raise web.HTTPNotFound
        if name not in self._thumbnails:
            self._thumbnails[name] = asyncio.ensure_future(asyncio.to_thread(self._thumbnail, name))
        try:
            data = await asyncio.shield(self._thumbnails[name])
        except StyleError as error:  # a file of the user's own that cannot be used
            raise web.HTTPNotFound from error
        return web.Response(body=data, content_type="image/jpeg")

    def _thumbnail(self, name: str) -> bytes:
        return encoded(thumbnail(self.controls.named(name)), ".jpg")

    async def _serve_socket(self, request: web.Request) -> web.StreamResponse:
        viewer = Viewer(self)
        try:
            return await self._server.serve(request, viewer, self.viewers, MAX_VIEWERS)
        finally:
            if self.bypasser is viewer:
                self.controls.bypass(False)
                self.bypasser = None

    async def _encode(self, function: Any, *values: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._encoder, function, *values)


MAX_SIZE = (1920, 1080)
"""Width and height that JPEG pictures are reduced to fit."""


def encode_jpeg(frame: LiveFrame, quality: int) -> bytes:
    """Encode the frame as JPEG, reduced to fit MAX_SIZE; `quality`: 0 to 100."""
    picture = frame.video
    scale = min(1.0, MAX_SIZE[0] / picture.width, MAX_SIZE[1] / picture.height)
    width, height = (max(1, round(side * scale)) for side in (picture.width, picture.height))
    pixels = picture.reformat(width=width, height=height, format="bgr24").to_ndarray()
    return _encoded(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])


def encode_png(frame: LiveFrame) -> bytes:
    """Encode the frame as PNG, at its full size."""
    return _encoded(".png", frame.video.to_ndarray(format="bgr24"), [])


def _encoded(extension: str, pixels: np.ndarray, options: list[int]) -> bytes:
    encoded, data = cv2.imencode(extension, pixels, options)
    assert encoded
    return data.tobytes()
