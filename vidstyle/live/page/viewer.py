"""One browser that shows the page: it is sent one frame at a time, and its messages are dispatched."""

from __future__ import annotations

import asyncio
import dataclasses
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from statistics import median_high
from typing import Annotated, Any

from vidstyle.live.control import Controls
from vidstyle.live.page.frame_feed import FrameFeed
from vidstyle.web.connection import PageConnection
from vidstyle.web.messages import CHECKS, FractionField, MessageError, TextOrEmpty, message

RECENT_LATENCY_COUNT = 60
"""Number of frames over which the latency is averaged."""
STATUS_SECONDS = 0.25
"""Interval at which the status is sent."""
MAX_VALUES = 200
"""Maximum number of values in a message."""


def _are_values(value: object) -> bool:
    """Whether it is an object of strings, numbers and booleans; parameters check their ranges later."""
    return (
        isinstance(value, dict)
        and 0 < len(value) <= MAX_VALUES
        and all(CHECKS[str](path) and isinstance(each, str | int | float) for path, each in value.items())
    )


StyleValues = Annotated[dict[str, Any], _are_values]


class Viewer(PageConnection):
    """Serves one WebSocket until it closes."""

    def __init__(self, feed: FrameFeed, fail: Callable[[BaseException], None]) -> None:
        super().__init__(fail, feed.meter.clock.now)
        self._feed = feed
        self._quality = JpegQuality()
        self._shown = asyncio.Event()
        self._sent = -1
        self._shown_style = ""
        self._latencies: deque[float] = deque([0.0], maxlen=RECENT_LATENCY_COUNT)

    async def greet(self) -> None:
        """Send the names of styles; begin to send their looks, frames, parameters and status."""
        await self.tell({"names": self._feed.controls.names})
        self.tasks.begin(self._send_looks())
        self.tasks.begin(self._send_frames())
        self.tasks.begin(self._send_status())

    def leave(self) -> None:
        """End the comparison with the source, unless another browser has requested one since."""
        if self._feed.comparer is self:
            self._feed.controls.bypass(False)
            self._feed.controls.compare(0)
            self._feed.comparer = None

    @message
    async def shown(self, number: int) -> None:
        """The page shows this frame, so the next one may follow."""
        if number != self._sent:
            raise MessageError("shown: was not sent")
        self._shown.set()

    @message
    async def set(self, values: StyleValues) -> None:
        await self._control(Controls.set_values, values)

    @message
    async def choose(self, style: str) -> None:
        await self._control(Controls.choose, style)

    @message
    async def vary(self, variant: TextOrEmpty) -> None:
        await self._control(Controls.vary, variant)

    @message
    async def next(self) -> None:
        await self._control(Controls.next_style)

    @message
    async def bypass(self, on: bool) -> None:
        self._feed.comparer = self
        await self._control(Controls.bypass, on)

    @message
    async def compare(self, at: FractionField) -> None:
        self._feed.comparer = self
        await self._control(Controls.compare, at)

    @message
    async def keep_size(self, on: bool) -> None:
        await self._control(Controls.keep_size, on)

    @message
    async def record(self, on: bool) -> None:
        await self._control(Controls.record, on)

    @message
    async def quit(self) -> None:
        await self._control(Controls.quit)

    async def _control(self, action: Callable[..., None], *values: Any) -> None:
        """Apply an action to the session, and notify all browsers."""
        try:
            await asyncio.to_thread(action, self._feed.controls, *values)
        finally:
            async with self._feed.changed:
                self._feed.changed.notify_all()

    async def _send_looks(self) -> None:
        await self.tell({"looks": await self._feed.looks()})

    async def _send_frames(self) -> None:
        feed, frame = self._feed, None
        while True:
            frame = await feed.newer(frame)
            data = await feed.jpeg(frame, self._quality.value)
            self._shown.clear()
            self._sent, begin = frame.number, feed.meter.clock.now()
            await self.send_picture(0, frame.number, 0, data)
            await self._shown.wait()
            self._shown_style = frame.style
            now = feed.meter.clock.now()
            self._quality.shown(now - begin)
            self._latencies.append(now - frame.captured)
            feed.count(frame)

    async def _send_status(self) -> None:
        style, feed = None, self._feed
        while True:
            if style is not feed.controls.style:
                style = feed.controls.style
                await self.tell({"panel": await feed.panel(style)})
            status = dataclasses.asdict(feed.controls.status())
            status["shown_ms"] = 1000 * median_high(self._latencies)
            status["shown_style"] = self._shown_style
            await self.tell({"status": status})
            with suppress(TimeoutError):
                async with asyncio.timeout(STATUS_SECONDS), feed.changed:
                    await feed.changed.wait()


class JpegQuality:
    """Adapts the quality of JPEG pictures to the time that a browser takes to show them.

    Attributes:
        value: the quality of the next picture, 0 to 100.

    >>> quality = JpegQuality()
    >>> for _ in range(30):
    ...     quality.shown(0.2)
    >>> quality.value
    60
    """

    LEVELS = (92, 85, 75, 60)
    SLOW, FAST = 0.060, 0.030
    """Seconds until a picture is shown: above the first the quality falls, below the second it rises."""
    FEW, MANY = 8, 90
    """Pictures in a row before it falls, and before it rises."""

    def __init__(self) -> None:
        self._level = self._slow = self._fast = 0

    @property
    def value(self) -> int:
        return self.LEVELS[self._level]

    def shown(self, seconds: float) -> None:
        """Record the time that a picture took."""
        self._slow = self._slow + 1 if seconds > self.SLOW else 0
        self._fast = self._fast + 1 if seconds < self.FAST else 0
        if self._slow >= self.FEW or self._fast >= self.MANY:
            level = self._level + (1 if self._slow else -1)
            self._level = min(max(level, 0), len(self.LEVELS) - 1)
            self._slow = self._fast = 0
