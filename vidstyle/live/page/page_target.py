"""The page as a target of a live session: the newest frame in browsers."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from aiohttp import web

from vidstyle.errors import counted, log
from vidstyle.gallery.style_samples import encode_picture
from vidstyle.gallery.thumbnail import restyle_thumbnail, thumbnail
from vidstyle.live.control import Controls
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.page.frame_feed import FrameFeed
from vidstyle.live.page.viewer import Viewer
from vidstyle.live.target import LiveFrame
from vidstyle.style import SOURCE, Style
from vidstyle.web.page_server import PageServer, named_pictures
from vidstyle.web.rendered_files import RENDERED_PATH, RenderedFiles

MAX_VIEWERS = 4
STATIC_FOLDER = Path(__file__).with_name("static")


class PageTarget(PageServer[Viewer]):
    """A target (see `Target`): a web page for browsers on this machine, or in its network.

    Attributes:
        url: the URL of the page, with its access token.
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
        self._controls, self._looks = controls, asyncio.Lock()
        self._feed = feed = FrameFeed(controls, meter or LatencyMeter())
        handlers = {
            "/picture.png": self._send_picture,
            "/thumbnail.jpg": named_pictures(lambda: controls.names, self._thumbnail),
            RENDERED_PATH: RenderedFiles(self._recording).serve,
            "/look.jpg": named_pictures(lambda: [SOURCE, *controls.names], self._look),
        }
        super().__init__(
            "page", lambda: Viewer(feed, self.fail), handlers, STATIC_FOLDER, "page.html",
            most=MAX_VIEWERS, port=port, address=address,
        )  # fmt: skip
        log.warning("page: %s", self.url)
        if address is not None:
            log.warning(
                "page: anyone in this network with its address can watch and control it; it is not encrypted"
            )
        if browse is not None:
            browse(self.one_time_url)

    @property
    def state(self) -> str:
        """The number of browsers that show the page, in words."""
        viewers = len(self.browsers)
        return counted(viewers, "browser") if viewers else "no browser"

    @property
    def delivered(self) -> int:
        """See `FrameFeed`."""
        return self._feed.delivered

    @property
    def dropped(self) -> int:
        """See `FrameFeed`."""
        return self._feed.dropped

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        self.submit(self._show, frame)

    def close(self) -> None:
        """See Target."""
        super().close()
        self._feed.close()

    async def _show(self, frame: LiveFrame) -> None:
        await self._feed.show(frame, bool(self.browsers))

    async def _send_picture(self, request: web.Request) -> web.StreamResponse:
        frame = self._feed.latest
        if frame is None:
            raise web.HTTPNotFound
        name = f"vidstyle-{self._controls.style.name.replace(':', '-')}-{frame.number}.png"
        headers = {"Content-Disposition": f'attachment; filename="{name}"'}
        return web.Response(body=await self._feed.png(frame), content_type="image/png", headers=headers)

    def _recording(self, number: int) -> Path | None:
        files = self._controls.recorded
        return files[number] if number < len(files) else None

    async def _thumbnail(self, name: str) -> bytes:
        style = self._without_regions(name)
        return await asyncio.to_thread(lambda: encode_picture(thumbnail(style), ".jpg"))

    async def _look(self, name: str) -> bytes:
        """Return the thumbnail of a style, or `SOURCE`, on an early picture of the session, one at a time."""
        style = Style(SOURCE) if name == SOURCE else self._without_regions(name)
        async with self._looks:
            picture = await self._feed.early_picture()
            return await asyncio.to_thread(lambda: encode_picture(restyle_thumbnail(style, picture), ".jpg"))

    def _without_regions(self, name: str) -> Style:
        """Return a style for thumbnails: regions take long to find."""
        return replace(self._controls.named(name), only="", keep="", behind=None)
