"""What all browsers are shown: the newest frame, made into a picture once, and how the session is."""

from __future__ import annotations

import asyncio
import dataclasses
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import cv2
import numpy as np

from vidstyle.live.control import Controls
from vidstyle.live.meter import Meter
from vidstyle.live.page.news import News
from vidstyle.live.page.panel import panel
from vidstyle.live.target import LiveFrame
from vidstyle.style import Style


class FrameHub:
    """Lives in one loop; every method is called from there.

    Attributes:
        controls: of the session.
        changed: told whenever a wish was carried out.
        delivered, dropped: frames that some browser has shown, and those left out for newer ones.
        viewers: the browsers there are.
        bypasser: the one of them that bypasses the style; when it goes, the bypass ends.
    """

    def __init__(self, controls: Controls, meter: Meter) -> None:
        self.controls, self._meter = controls, meter
        self.changed, self._fresh = News(), News()
        self.delivered = self.dropped = 0
        self.viewers: set[object] = set()
        self.bypasser: object | None = None
        self._latest: LiveFrame | None = None
        self._taken: LiveFrame | None = None
        self._counted = -1
        self._jpegs: dict[int, asyncio.Future[bytes]] = {}
        self._starts: dict[str, Style] = {}
        self._worker = ThreadPoolExecutor(1, "vidstyle page pictures")

    def leave(self, viewer: object) -> None:
        """A browser has gone."""
        self.viewers.discard(viewer)
        if self.bypasser is viewer:
            self.controls.bypass(False)
            self.bypasser = None

    def close(self) -> None:
        """Make no more pictures."""
        self._worker.shutdown(wait=False)

    def show(self, frame: LiveFrame) -> None:
        """The newest frame."""
        self.dropped += bool(self.viewers) and self._latest is not None and self._latest is not self._taken
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

    async def png(self) -> tuple[str, bytes] | None:
        """A name for the newest frame, and the frame itself as PNG; None before there is one."""
        frame = self._latest
        if frame is None:
            return None
        name = f"vidstyle-{self.controls.style_name.replace(':', '-')}-{frame.number}.png"
        return name, await self._work(png, frame)

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


LARGEST = (1920, 1080)
"""Width and height within which pictures are sent; more than that no window shows at once."""


def jpeg(frame: LiveFrame, quality: int) -> bytes:
    """The frame as JPEG, reduced to fit LARGEST; `quality`: 0 to 100."""
    picture = frame.picture
    scale = min(1.0, LARGEST[0] / picture.width, LARGEST[1] / picture.height)
    width, height = (max(1, round(side * scale)) for side in (picture.width, picture.height))
    pixels = picture.reformat(width=width, height=height, format="bgr24").to_ndarray()
    return _encoded(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])


def png(frame: LiveFrame) -> bytes:
    """The frame as PNG, at its full size and without loss."""
    return _encoded(".png", frame.picture.to_ndarray(format="bgr24"), [])


def _encoded(ending: str, pixels: np.ndarray, options: list[int]) -> bytes:
    encoded, data = cv2.imencode(ending, pixels, options)
    assert encoded
    return data.tobytes()


class Quality:
    """How good the JPEG pictures for one browser are, by how long it takes to show one.

    Attributes:
        value: 0 to 100.

    >>> quality = Quality()
    >>> for _ in range(30):
    ...     quality.shown(0.2)
    >>> quality.value
    60
    """

    STEPS = (92, 85, 75, 60)
    SLOW, QUICK = 0.060, 0.030
    """Seconds until a picture is shown: above the first the quality falls, below the other it rises."""
    FEW, MANY = 8, 90
    """Pictures in a row, before it falls and before it rises."""

    def __init__(self) -> None:
        self._step = self._slow = self._quick = 0

    @property
    def value(self) -> int:
        """For the next picture."""
        return self.STEPS[self._step]

    def shown(self, seconds: float) -> None:
        """Tell how long a picture took."""
        self._slow = self._slow + 1 if seconds > self.SLOW else 0
        self._quick = self._quick + 1 if seconds < self.QUICK else 0
        if self._slow >= self.FEW:
            self._go(self._step + 1)
        elif self._quick >= self.MANY:
            self._go(self._step - 1)

    def _go(self, step: int) -> None:
        self._step = min(max(step, 0), len(self.STEPS) - 1)
        self._slow = self._quick = 0
