"""One browser that shows the page: it is sent one frame at a time, and its messages are dispatched."""

from __future__ import annotations

import asyncio
import dataclasses
import json
from collections import deque
from contextlib import suppress
from statistics import median_high
from typing import TYPE_CHECKING, Any

from aiohttp import web

from vidstyle.errors import VidstyleError
from vidstyle.live.page.actions import MESSAGE_FIELDS, dispatch
from vidstyle.web.messages import MessageError, RateLimit, read_message, receive, refuse

if TYPE_CHECKING:
    from vidstyle.live.page.page_target import PageTarget

MAX_MESSAGES = 250
"""Messages a second; the page sends one for each frame, and one for each answer to a slider."""
RECENT_LATENCY_COUNT = 60
"""Number of frames over which the latency is averaged."""
STATUS_SECONDS = 0.25
"""Interval at which the status is sent."""


class Viewer:
    """Serves one WebSocket until it closes."""

    def __init__(self, page: PageTarget) -> None:
        self._page = page
        self._quality = JpegQuality()
        self._shown = asyncio.Event()
        self._sent = -1
        self._latencies: deque[float] = deque([0.0], maxlen=RECENT_LATENCY_COUNT)
        self._limit = RateLimit(MAX_MESSAGES, self._page.meter.clock.now)

    async def serve(self, socket: web.WebSocketResponse) -> None:
        """Send frames, status and parameters, and dispatch messages, until the socket closes."""
        self._socket = socket
        invalid = None
        try:
            async with asyncio.TaskGroup() as tasks:
                await self._send({"names": self._page.controls.names})
                sending = [tasks.create_task(work) for work in (self._send_frames(), self._send_status())]
                invalid = await receive(socket, self._handle)
                for task in sending:
                    task.cancel()
        except* ConnectionError:  # the browser has gone without closing the socket
            pass
        if invalid is not None:
            await refuse(socket, invalid)

    async def _send_frames(self) -> None:
        frame = None
        while True:
            frame = await self._page.newer(frame)
            data = await self._page.jpeg(frame, self._quality.value)
            self._shown.clear()
            self._sent, begin = frame.number, self._page.meter.clock.now()
            await self._socket.send_bytes(frame.number.to_bytes(8, "big") + data)
            await self._shown.wait()
            now = self._page.meter.clock.now()
            self._quality.shown(now - begin)
            self._latencies.append(now - frame.captured)
            self._page.count(frame)

    async def _send_status(self) -> None:
        style = None
        while True:
            if style is not self._page.controls.style:
                style = self._page.controls.style
                await self._send({"panel": await self._page.panel(style)})
            status = dataclasses.asdict(self._page.controls.status())
            status["shown_ms"] = 1000 * median_high(self._latencies)
            await self._send({"status": status})
            with suppress(TimeoutError):
                async with asyncio.timeout(STATUS_SECONDS), self._page.changed:
                    await self._page.changed.wait()

    async def _handle(self, text: str | bytes) -> None:
        self._limit.count()
        message = read_message(text, MESSAGE_FIELDS)
        if message["do"] == "shown":
            if message["number"] != self._sent:
                raise MessageError("shown: was not sent")
            self._shown.set()
            return
        if message["do"] == "bypass":
            self._page.bypasser = self if message["on"] else None
        try:
            await asyncio.to_thread(dispatch, message, self._page.controls)
            answer = {"done": message["do"]}
        except VidstyleError as error:
            answer = {"done": message["do"], "error": str(error)}
        async with self._page.changed:
            self._page.changed.notify_all()
        await self._send(answer)

    async def _send(self, message: dict[str, Any]) -> None:
        await self._socket.send_str(json.dumps(message))


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
