"""Sends a page the frames of the clip: one, or as they play, and restyled where the server restyles."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.errors import VidstyleError
from vidstyle.preview.encode import encode

if TYPE_CHECKING:
    from vidstyle.design.page.page_connection import PageConnection

SOURCE, STYLED = 1, 2
"""Kinds of pictures."""
IDLE_SECONDS = 0.35
"""After so long without a change a picture that was made small to be quick is made larger."""


class FrameSender:
    """Sends frames to one page.

    Attributes:
        number: of the frame that is shown.
    """

    def __init__(self, page: PageConnection) -> None:
        self._page = page
        self.number = 0
        self._playing: asyncio.Task[None] | None = None
        self._restyling: asyncio.Task[None] | None = None
        self._wanted = asyncio.Event()

    def stop(self) -> None:
        """Stop playing."""
        if self._playing is not None:
            self._playing.cancel()
            self._playing = None

    def play(self, at: int, first: int, last: int, fps: float) -> None:
        """Play frames first..last over and over, beginning with `at`."""
        self.stop()
        self._playing = self._page.server.begin(self._play(at, first, last, fps))

    async def send(self) -> None:
        """Send the frame that is shown, exactly, and have it restyled where the server restyles."""
        clip = self._page.server.designer.clip
        if clip.live:
            self.play(0, 0, 0, clip.fps)
            return
        frame = await self._page.server.run(clip.frame, self.number, self._page.side)
        await self._send(SOURCE, frame, exact=True)
        if self._page.where == "server":
            self.restyle()

    def restyle(self) -> None:
        """Have the frame that is shown restyled; the newest wish counts."""
        self._wanted.set()
        is_idle = self._restyling is None or self._restyling.done()
        if is_idle and self._playing is None:
            self._restyling = self._page.server.begin(self._restyle())

    async def _restyle(self) -> None:
        while self._wanted.is_set():
            self._wanted.clear()
            try:
                if await self._restyled() and not await self._is_wanted_soon():
                    await self._restyled(careful=True)
            except VidstyleError as error:
                await self._page.tell({"notice": str(error)})

    async def _is_wanted_soon(self) -> bool:
        with suppress(TimeoutError):
            async with asyncio.timeout(IDLE_SECONDS):
                await self._wanted.wait()
        return self._wanted.is_set()

    async def _restyled(self, careful: bool = False) -> bool:
        """Send the frame restyled; returns whether it is smaller than it might be."""
        page, server, clip = self._page, self._page.server, self._page.server.designer.clip
        style, side = page.style, min(page.side, *clip.size)
        if style is None:
            return False
        make = server.restyler.careful if careful else server.restyler.quick
        picture = await server.picture(make, style, clip, self.number, side)
        await self._send(STYLED, picture, exact=careful)
        return min(picture.shape[:2]) < side

    async def _play(self, at: int, first: int, last: int, fps: float) -> None:
        loop = asyncio.get_running_loop()
        page, began = self._page, loop.time()
        while True:
            passed = int((loop.time() - began) * fps)
            self.number = first + (at - first + passed) % (last - first + 1)
            try:
                clip = page.server.designer.clip
                frame = await page.server.run(clip.frame, self.number, page.side)
                await self._send(SOURCE, frame)
                if page.where == "server":
                    await self._restyled()
            except VidstyleError as error:
                await page.tell({"notice": str(error)})
                return
            await asyncio.sleep(max(0.0, began + (passed + 1) / fps - loop.time()))

    async def _send(self, kind: int, picture: np.ndarray, exact: bool = False) -> None:
        page = self._page
        number, document = self.number, page.server.designer.document
        data = await asyncio.to_thread(encode, picture, "png" if exact else "jpeg")
        await page.send_picture(kind, number, document.revision if document else 0, data)
