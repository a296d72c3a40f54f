"""Send frames of the clip to a browser: single frames or playback, rendered if the server renders."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.errors import VidstyleError
from vidstyle.preview.encode import encode

if TYPE_CHECKING:
    from vidstyle.design.page.page_connection import PageConnection


class PictureType(IntEnum):
    """The types of pictures in messages to the page; `preview.js` lists the same."""

    SOURCE = 1
    STYLED = 2
    STEP = 3
    EXACT = 4
    STYLE = 5
    STEADY = 6


IDLE_SECONDS = 0.35
"""Time without a change after which a reduced preview is rendered again at a larger size."""


class FrameSender:
    """Sends frames to one browser.

    Attributes:
        number: the number of the current frame.
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
        """Play frames first..last in a loop, starting at `at`."""
        self.stop()
        self._playing = self._page.server.begin(self._play(at, first, last, fps))

    async def send(self) -> None:
        """Send the current frame losslessly, and render it if the server renders."""
        clip = self._page.server.designer.clip
        if clip.live:
            self.play(0, 0, 0, clip.fps)
            return
        frame = await self._page.server.run(clip.frame, self.number, self._page.side)
        await self._send(PictureType.SOURCE, frame, exact=True)
        if self._page.where == "server":
            self.restyle()

    def restyle(self) -> None:
        """Render the current frame; of several requests only the newest is served."""
        self._wanted.set()
        is_idle = self._restyling is None or self._restyling.done()
        if is_idle and self._playing is None:
            self._restyling = self._page.server.begin(self._restyle())

    async def _restyle(self) -> None:
        while self._wanted.is_set():
            self._wanted.clear()
            try:
                if await self._send_styled() and not await self._is_wanted_soon():
                    await self._send_styled(large=True)
            except VidstyleError as error:
                await self._page.tell({"notice": str(error)})

    async def _is_wanted_soon(self) -> bool:
        with suppress(TimeoutError):
            async with asyncio.timeout(IDLE_SECONDS):
                await self._wanted.wait()
        return self._wanted.is_set()

    async def _send_styled(self, large: bool = False) -> bool:
        """Render and send the current frame; return whether it is smaller than the preview size."""
        page, server, clip = self._page, self._page.server, self._page.server.designer.clip
        style, side = page.style, min(page.side, *clip.size)
        if style is None:
            return False
        make = server.restyler.render_large if large else server.restyler.render_preview
        picture = await server.picture(make, style, clip, self.number, side)
        await self._send(PictureType.STYLED, picture, exact=large)
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
                await self._send(PictureType.SOURCE, frame)
                if page.where == "server":
                    await self._send_styled()
            except VidstyleError as error:
                await page.tell({"notice": str(error)})
                return
            await asyncio.sleep(max(0.0, began + (passed + 1) / fps - loop.time()))

    async def _send(self, kind: int, picture: np.ndarray, exact: bool = False) -> None:
        page = self._page
        number, document = self.number, page.server.designer.document
        data = await asyncio.to_thread(encode, picture, "png" if exact else "jpeg")
        await page.send_picture(kind, number, document.revision if document else 0, data)
