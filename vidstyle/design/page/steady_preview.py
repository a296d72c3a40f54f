"""One second of film with temporal smoothing, with progress and cancellation."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

from vidstyle.design.page.design_session import DesignSession
from vidstyle.design.page.frames import FrameSender, PictureType
from vidstyle.design.restyling import render_second
from vidstyle.preview.encode import encode
from vidstyle.preview.outputs import JobSlot
from vidstyle.web.connection import PageConnection

MAX_STEADY_SIDE_PX = 270
"""Maximum shorter side of the pictures."""


class SteadyPreview:
    """Renders one second at a time, and reports progress to all browsers."""

    def __init__(self, session: DesignSession, tell: Callable[[dict[str, Any]], Awaitable[None]]) -> None:
        """`tell`: sends a message to all browsers."""
        self._session, self._tell_all = session, tell
        self._slot = JobSlot()
        self.cancel = self._slot.cancel

    async def send(self, page: PageConnection, frames: FrameSender) -> None:
        """Send one second of the clip, rendered with temporal smoothing, to a browser.

        Args:
            frames: sends the frames of this browser.

        Raises:
            UsageError: no style is open, or another second is being rendered.
        """
        session, shown = self._session, frames.shown
        style, clip = session.designer.opened.valid_style(), session.designer.clip
        with self._slot.begin() as stop:
            made = render_second(style, clip, shown.number, min(shown.side, MAX_STEADY_SIDE_PX), stop.is_set)
            done, revision = 0, session.revision
            try:
                while (item := await session.picture(next, made, None)) is not None:
                    number, count, picture = item
                    done += 1
                    data = await asyncio.to_thread(encode, picture, "jpeg")
                    await page.send_picture(PictureType.STEADY, number, revision, data)
                    await self._tell(done, count, finished=False)
            finally:
                await session.picture(_close, made)
        await self._tell(done, done, finished=True)

    async def _tell(self, done: int, total: int, finished: bool) -> None:
        progress = {"kind": "steady", "done": done, "total": total, "finished": finished}
        await self._tell_all({"progress": progress})


def _close(made: Iterator[Any]) -> None:
    made.close()  # type: ignore[attr-defined]
