"""What all browsers are sent: the newest frame, encoded once for all of them, and the session's status."""

from __future__ import annotations

import asyncio
import dataclasses
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import cv2
import numpy as np

from vidstyle.live.control import Controls
from vidstyle.live.page.panel import panel
from vidstyle.live.target import LiveFrame
from vidstyle.live.timing import LatencyMeter
from vidstyle.style import Style


class FrameHub:
    """Distributes frames to viewers; all coroutines run in one event loop.

    Attributes:
        controls: of the session.
        changed: notified whenever a message was dispatched.
        delivered, dropped: number of frames that a browser has shown, and that none was sent.
        viewers: the browsers that are connected.
        bypasser: the one of them that bypasses the style; the bypass ends when it disconnects.
    """

    def __init__(self, controls: Controls, meter: LatencyMeter) -> None:
        self.controls, self._meter = controls, meter
        self.changed, self._arrived = asyncio.Condition(), asyncio.Condition()
        self.delivered = self.dropped = 0
        self.viewers: set[object] = set()
        self.bypasser: object | None = None
        self._latest: LiveFrame | None = None
        self._sent: LiveFrame | None = None
        self._counted = -1
        self._jpegs: dict[int, asyncio.Future[bytes]] = {}
        self._initial_styles: dict[str, Style] = {}
        self._encoder = ThreadPoolExecutor(1, "vidstyle page pictures")

    def leave(self, viewer: object) -> None:
        """A browser has disconnected."""
        self.viewers.discard(viewer)
        if self.bypasser is viewer:
            self.controls.bypass(False)
            self.bypasser = None

    def close(self) -> None:
        """Stop encoding."""
        self._encoder.shutdown(wait=False)

    async def show(self, frame: LiveFrame) -> None:
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
            self._meter.record(frame.captured)

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
            return await self._encode(jpeg, frame, quality)
        if quality not in self._jpegs:
            self._jpegs[quality] = asyncio.ensure_future(self._encode(jpeg, frame, quality))
        return await asyncio.shield(self._jpegs[quality])

    async def png(self) -> tuple[str, bytes] | None:
        """A file name for the newest frame, and the frame as PNG; None before the first frame."""
        frame = self._latest
        if frame is None:
            return None
        name = f"vidstyle-{self.controls.style_name.replace(':', '-')}-{frame.number}.png"
        return name, await self._encode(png, frame)

    async def panel(self, style: Style) -> dict[str, Any]:
        """All parameters of the style, see `panel`."""
        if style.name not in self._initial_styles:
            self._initial_styles[style.name] = self.controls.without_variant(style.name)
        return await asyncio.to_thread(panel, style, self._initial_styles[style.name])

    def status(self) -> dict[str, Any]:
        """The status of the session as plain values."""
        return dataclasses.asdict(self.controls.status())

    async def _encode(self, function: Any, *values: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._encoder, function, *values)


MAX_SIZE = (1920, 1080)
"""Width and height that JPEG pictures are reduced to fit."""


def jpeg(frame: LiveFrame, quality: int) -> bytes:
    """Encode the frame as JPEG, reduced to fit MAX_SIZE; `quality`: 0 to 100."""
    picture = frame.video
    scale = min(1.0, MAX_SIZE[0] / picture.width, MAX_SIZE[1] / picture.height)
    width, height = (max(1, round(side * scale)) for side in (picture.width, picture.height))
    pixels = picture.reformat(width=width, height=height, format="bgr24").to_ndarray()
    return _encoded(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])


def png(frame: LiveFrame) -> bytes:
    """Encode the frame as PNG, at its full size."""
    return _encoded(".png", frame.video.to_ndarray(format="bgr24"), [])


def _encoded(extension: str, pixels: np.ndarray, options: list[int]) -> bytes:
    encoded, data = cv2.imencode(extension, pixels, options)
    assert encoded
    return data.tobytes()
