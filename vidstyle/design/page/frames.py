"""Send frames of the clip to a browser: single frames or playback, rendered if the server renders."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any, Literal

import numpy as np

from vidstyle.cues.cue_list import CueList
from vidstyle.design.page.design_session import DesignSession
from vidstyle.errors import VidstyleError
from vidstyle.preview.encode import encode
from vidstyle.style import Style
from vidstyle.style.wiring import needs_cpu
from vidstyle.web.connection import PageConnection


class PictureType(IntEnum):
    """The types of pictures in messages to the page; `preview.js` lists the same."""

    SOURCE = 1
    STYLED = 2
    STEP = 3
    EXACT = 4
    STYLE = 5
    STEADY = 6
    FACES = 7
    OPENED = 8


IDLE_SECONDS = 0.35
"""Time without a change after which a reduced preview is rendered again at its final size."""


@dataclass
class ShownFrame:
    """What one browser shows.

    Attributes:
        number: the number of the current frame.
        solo: the number of the soloed step, or None.
        side: the shorter side of the preview in pixels.
        where: the renderer.
        cues: the styles of the film over time, which are shown instead of the open style, or None.
    """

    number: int = 0
    solo: int | None = None
    side: int = 360
    where: Literal["page", "server"] = "page"
    cues: CueList | None = None


class FrameSender:
    """Sends frames to one browser.

    Attributes:
        shown: what the browser shows.
    """

    def __init__(self, session: DesignSession, page: PageConnection) -> None:
        self.shown = ShownFrame()
        self._session, self._page = session, page
        self._playing: asyncio.Task[None] | None = None
        self._restyling: asyncio.Task[None] | None = None
        self._wanted = asyncio.Event()
        self._has_faces = False
        self._final: tuple[Any, ...] | None = None

    @property
    def style(self) -> Style | None:
        """The style that the browser shows; None if no style is open."""
        return self._session.shown_style(self.shown.solo)

    @property
    def is_rendering(self) -> bool:
        """Whether the server renders, as the page cannot, or should not."""
        if self.shown.cues is not None or self.shown.where == "server":
            return True
        return self.style is not None and needs_cpu(self.style)

    def stop(self) -> None:
        """Stop playing."""
        if self._playing is not None:
            self._playing.cancel()
            self._playing = None

    def play(self, at: int, first: int, last: int, fps: float) -> None:
        """Play frames first..last in a loop, starting at `at`."""
        self.stop()
        self._playing = self._page.tasks.begin(self._play(at, first, last, fps))

    async def send(self) -> None:
        """Send the current frame losslessly, and render it if the server renders."""
        clip = self._session.designer.clip
        if clip.live:
            self.play(0, 0, 0, clip.fps)
            return
        self._final = None
        number = self.shown.number
        frame = await self._session.run(clip.frame, number, self.shown.side)
        await self._send(PictureType.SOURCE, number, frame, self._session.revision, exact=True)
        self.restyle()

    def restyle(self) -> None:
        """Render what the page does not; of several requests only the newest is served."""
        self._wanted.set()
        is_idle = self._restyling is None or self._restyling.done()
        if is_idle and self._playing is None:
            self._restyling = self._page.tasks.begin(self._restyle())

    async def settle(self) -> None:
        """Wait until the current frame is shown at its final size."""
        if self._restyling is not None:
            await asyncio.wait([self._restyling])

    async def _restyle(self) -> None:
        while self._wanted.is_set():
            self._wanted.clear()
            try:
                if not self.is_rendering:
                    await self._send_faces()
                elif await self._is_draft_shown() and not await self._is_wanted_soon():
                    await self._send_styled(large=True)
            except VidstyleError as error:
                await self._page.tell({"notice": str(error)})

    async def _is_draft_shown(self) -> bool:
        """Send a draft; but if only the name or the file has changed, the final picture stays."""
        return (self._final is not None and self._final == self._subject) or await self._send_styled()

    @property
    def _subject(self) -> tuple[Any, ...]:
        """What the picture depends on."""
        style, shown = self.style, self.shown
        look = style and replace(style, name="", folder=None)
        return self._session.designer.clip, shown.number, shown.side, shown.cues, look

    async def _is_wanted_soon(self) -> bool:
        with suppress(TimeoutError):
            async with asyncio.timeout(IDLE_SECONDS):
                await self._wanted.wait()
        return self._wanted.is_set()

    async def _send_styled(self, large: bool = False) -> bool:
        """Render and send the current frame; return whether `large` would show more."""
        session, clip, style = self._session, self._session.designer.clip, self.style
        side, number, revision = min(self.shown.side, *clip.size), self.shown.number, session.revision
        if style is None:
            return False
        subject = self._subject
        if self.shown.cues is not None:
            moment = self.shown.cues.at(number / clip.fps)
            made = session.picture(session.restyler.render_moment, moment, clip, number, side, large)
        else:
            made = session.picture(self._renderer(large), style, clip, number, side)
        picture, is_reduced = await made
        is_final = large or (not is_reduced and self._playing is None)
        await self._send(PictureType.STYLED, number, picture, revision, exact=is_final)
        self._final = subject if is_final else None
        return bool(is_reduced)

    def _renderer(self, large: bool) -> Callable[..., tuple[np.ndarray, bool]]:
        restyler = self._session.restyler
        if large:
            return restyler.render_large
        return restyler.render_preview if self._playing is None else restyler.render_playing

    async def _send_faces(self) -> None:
        """Render and send the faces of the current frame, which the page lays over its own picture."""
        session, clip, style = self._session, self._session.designer.clip, self.style
        if style is None:
            return
        side, number, revision = min(self.shown.side, *clip.size), self.shown.number, session.revision
        picture = await session.picture(session.restyler.render_faces, style, clip, number, side)
        had_faces, self._has_faces = self._has_faces, picture is not None
        if picture is None and had_faces:
            picture = np.zeros((1, 1, 4), np.uint8)  # replaces the faces that the page has
        if picture is not None:
            await self._send(PictureType.FACES, number, picture, revision, exact=True)

    async def _play(self, at: int, first: int, last: int, fps: float) -> None:
        loop = asyncio.get_running_loop()
        shown, began = self.shown, loop.time()
        while True:
            passed = int((loop.time() - began) * fps)
            shown.number = first + (at - first + passed) % (last - first + 1)
            try:
                clip, number = self._session.designer.clip, shown.number
                frame = await self._session.run(clip.frame, number, shown.side)
                await self._send(PictureType.SOURCE, number, frame, self._session.revision)
                if self.is_rendering:
                    await self._send_styled()
            except VidstyleError as error:
                await self._page.tell({"notice": str(error)})
                return
            await asyncio.sleep(max(0.0, began + (passed + 1) / fps - loop.time()))

    async def _send(
        self, kind: int, number: int, picture: np.ndarray, revision: int, exact: bool = False
    ) -> None:
        data = await asyncio.to_thread(encode, picture, "png" if exact else "jpeg")
        await self._page.send_picture(kind, number, revision, data)
