"""One browser that shows the page: frames go to it one at a time, its wishes come back."""

from __future__ import annotations

import asyncio
import json
import logging
import time
from collections import deque
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode

from vidstyle.errors import VidstyleError
from vidstyle.live.page.hub import FrameHub, Quality
from vidstyle.live.page.messages import MessageError, carry_out, read_message

MAX_MESSAGES = 250
"""Messages a second; our page sends one for each frame and one for each answer to a slider."""
LATENCIES = 60
STATUS_SECONDS = 0.25

log = logging.getLogger("vidstyle")


class Viewer:
    """Serves one socket until it closes.

    Attributes:
        latency_ms: median from capture to the screen, of the last frames; 0 before the first.
    """

    def __init__(self, socket: ServerConnection, exhibit: FrameHub) -> None:
        self._socket, self._exhibit = socket, exhibit
        self._quality = Quality()
        self._shown = asyncio.Event()
        self._sent = -1
        self._latencies: deque[float] = deque(maxlen=LATENCIES)
        self._seconds = int(time.monotonic())
        self._messages = 0

    @property
    def latency_ms(self) -> float:
        """See the class."""
        return 1000 * sorted(self._latencies)[len(self._latencies) // 2] if self._latencies else 0.0

    async def serve(self) -> None:
        """Send pictures and news, and do what is asked for, until the socket closes."""
        try:
            async with asyncio.TaskGroup() as tasks:
                await self._tell({"names": self._exhibit.controls.names})
                sending = [tasks.create_task(work) for work in (self._send_pictures(), self._send_news())]
                await self._listen()
                for task in sending:
                    task.cancel()
        except* ConnectionClosed:  # without a farewell
            pass

    async def _listen(self) -> None:
        try:
            async for text in self._socket:
                await self._hear(text)
        except MessageError as error:
            log.warning("page: a browser was sent away: %s", error)
            await self._socket.close(CloseCode.POLICY_VIOLATION, "not a message of this page")

    async def _send_pictures(self) -> None:
        frame = None
        while True:
            frame = await self._exhibit.newer(frame)
            data = await self._exhibit.jpeg(frame, self._quality.value)
            self._shown.clear()
            self._sent, begin = frame.number, time.monotonic()
            await self._socket.send(frame.number.to_bytes(8, "big") + data)
            await self._shown.wait()
            now = time.monotonic()
            self._quality.shown(now - begin)
            self._latencies.append(now - frame.captured)
            self._exhibit.count(frame)

    async def _send_news(self) -> None:
        style = None
        while True:
            if style is not self._exhibit.controls.style:
                style = self._exhibit.controls.style
                await self._tell({"panel": await self._exhibit.panel(style)})
            await self._tell({"status": self._exhibit.status() | {"shown_ms": self.latency_ms}})
            await self._exhibit.changed.wait_for(STATUS_SECONDS)

    async def _hear(self, text: str | bytes) -> None:
        self._count_message()
        message = read_message(text)
        if message["do"] == "shown":
            if message["number"] != self._sent:
                raise MessageError("shown: was not sent")
            self._shown.set()
            return
        if message["do"] == "bypass":
            self._exhibit.bypasser = self if message["on"] else None
        try:
            await asyncio.to_thread(carry_out, message, self._exhibit.controls)
            answer = {"done": message["do"]}
        except VidstyleError as error:
            answer = {"done": message["do"], "error": str(error)}
        self._exhibit.changed.tell()
        await self._tell(answer)

    def _count_message(self) -> None:
        second = int(time.monotonic())
        self._messages = self._messages + 1 if second == self._seconds else 1
        self._seconds = second
        if self._messages > MAX_MESSAGES:
            raise MessageError("more messages than anyone can mean")

    async def _tell(self, thing: dict[str, Any]) -> None:
        await self._socket.send(json.dumps(thing))
