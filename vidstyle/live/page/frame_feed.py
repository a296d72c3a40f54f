"""What the browsers of a live session share: the newest frame, encoded once for all, and the panel."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np

from vidstyle.core.convert import to_rgb
from vidstyle.core.uniform import is_nearly_uniform
from vidstyle.gallery.search_words import describe_look
from vidstyle.live.control import Controls
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.target import LiveFrame
from vidstyle.media.frame import frame_from_picture
from vidstyle.media.picture_bytes import jpeg_bytes, png_bytes
from vidstyle.style import Style
from vidstyle.style.panel import panel

MAX_SIZE = (1920, 1080)
"""Width and height that JPEG pictures are reduced to fit."""


class FrameFeed:
    """Hands the newest frame to browsers. All coroutines run in the server's event loop.

    Attributes:
        controls, meter: of the session.
        changed: notified whenever a message was dispatched.
        latest: the newest frame, or None.
        delivered, dropped: number of frames that a browser has shown, and that none was sent.
        comparer: the connection that compared with the source last, or None.
    """

    def __init__(self, controls: Controls, meter: LatencyMeter) -> None:
        self.controls, self.meter = controls, meter
        self.changed, self._arrived = asyncio.Condition(), asyncio.Condition()
        self.delivered = self.dropped = 0
        self.comparer: object | None = None
        self.latest: LiveFrame | None = None
        self._sent: LiveFrame | None = None
        self._counted = -1
        self._jpegs: dict[int, asyncio.Future[bytes]] = {}
        self._initial_styles: dict[str, Style] = {}
        self._early_picture: np.ndarray | None = None
        self._encoder = ThreadPoolExecutor(1, "vidstyle page pictures")

    def close(self) -> None:
        """End the thread that encodes."""
        self._encoder.shutdown(wait=False)

    async def show(self, frame: LiveFrame, is_seen: bool) -> None:
        """Make this the newest frame; `is_seen`: whether there is a browser."""
        async with self._arrived:
            self.dropped += is_seen and self.latest is not self._sent
            self.latest = frame
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
            await self._arrived.wait_for(lambda: self.latest is not frame)
        assert self.latest is not None
        self._sent = self.latest
        return self.latest

    async def early_picture(self) -> np.ndarray:
        """Wait for a picture of the source that is not nearly uniform, and keep it: H x W x 3 uint8 RGB."""
        while self._early_picture is None:
            frame = self.latest
            picture = None if frame is None else await asyncio.to_thread(_source_picture, frame)
            if picture is not None and not is_nearly_uniform(picture):
                self._early_picture = picture
                break
            async with self._arrived:
                await self._arrived.wait_for(lambda: self.latest is not frame)  # noqa: B023
        return self._early_picture

    async def jpeg(self, frame: LiveFrame, quality: int) -> bytes:
        """The frame as JPEG, encoded once for each quality."""
        if frame is not self.latest:
            return await self._encode(encode_jpeg, frame, quality)
        if quality not in self._jpegs:
            self._jpegs[quality] = asyncio.ensure_future(self._encode(encode_jpeg, frame, quality))
        return await asyncio.shield(self._jpegs[quality])

    async def png(self, frame: LiveFrame) -> bytes:
        """The frame as PNG; see `encode_png`."""
        return await self._encode(encode_png, frame)

    async def panel(self, style: Style) -> dict[str, Any]:
        """All parameters of the style, see `panel`."""
        if style.name not in self._initial_styles:
            self._initial_styles[style.name] = self.controls.without_variant(style.name)
        return await asyncio.to_thread(panel, style, self._initial_styles[style.name])

    async def looks(self) -> list[dict[str, Any]]:
        """What a search knows of each style, see `describe_look`."""
        return await asyncio.to_thread(
            lambda: [describe_look(name, partial(self.controls.named, name)) for name in self.controls.names]
        )

    async def _encode(self, function: Any, *values: Any) -> bytes:
        return await asyncio.get_running_loop().run_in_executor(self._encoder, function, *values)


def _source_picture(frame: LiveFrame) -> np.ndarray:
    """Return the unstyled picture of a frame, H x W x 3 uint8 RGB."""
    return to_rgb(frame.original or frame.picture)


def encode_jpeg(frame: LiveFrame, quality: int) -> bytes:
    """Encode the frame as JPEG, reduced to fit MAX_SIZE; `quality`: 0 to 100."""
    picture = frame.video
    scale = min(1.0, MAX_SIZE[0] / picture.width, MAX_SIZE[1] / picture.height)
    width, height = (max(1, round(side * scale)) for side in (picture.width, picture.height))
    pixels = picture.reformat(width=width, height=height, format="rgb24").to_ndarray()
    return jpeg_bytes(pixels, quality, full_chroma=False)


def encode_png(frame: LiveFrame) -> bytes:
    """Encode the frame as PNG, at its full size, without a comparison with the original."""
    video = frame.video if frame.undivided is None else frame_from_picture(frame.undivided)
    return png_bytes(video.to_ndarray(format="rgb24"))
