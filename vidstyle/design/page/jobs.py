"""Long jobs with progress and cancellation: render the film, or one second with temporal smoothing."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from typing import TYPE_CHECKING, Any

from vidstyle.design.page.design_session import DesignSession
from vidstyle.design.page.frames import FrameSender, PictureType
from vidstyle.design.restyling import render_second
from vidstyle.errors import VidstyleError
from vidstyle.preview.encode import encode
from vidstyle.preview.outputs import JobSlot, file_of, output_path
from vidstyle.web.connection import PageConnection

if TYPE_CHECKING:
    from vidstyle.pipeline.progress import Progress

MAX_STEADY_SIDE_PX = 270
"""Maximum shorter side of the pictures of `Jobs.steady`."""


class Jobs:
    """Runs one job at a time, and reports progress to all browsers."""

    def __init__(self, session: DesignSession, tell: Callable[[dict[str, Any]], Awaitable[None]]) -> None:
        """`tell`: sends a message to all browsers."""
        self._session, self._tell_all = session, tell
        self._slot = JobSlot()
        self.cancel = self._slot.cancel

    async def render(self, name: str, overwrite: bool, frames: int | None) -> None:
        """Render the clip to a file in the working folder.

        Raises:
            UsageError: the name is invalid or exists, no style is open, or the clip is a camera.
            VidstyleError: rendering failed.
        """
        from vidstyle.media.write.writer import WriteOptions
        from vidstyle.pipeline.render import render

        designer, loop = self._session.designer, asyncio.get_running_loop()
        path = output_path(designer.folder, name, overwrite=overwrite)
        style = designer.opened.valid_style()
        source = await self._session.run(file_of, designer.clip)

        def report(progress: Progress) -> None:
            fields = {"text": progress.pace_text, "finished": False}
            work = self._tell("render", progress.frames, progress.total_frames, **fields)
            asyncio.run_coroutine_threadsafe(work, loop)

        with self._slot.begin() as stop:
            try:
                summary = await asyncio.to_thread(
                    render, source, path, style, write=WriteOptions(overwrite=overwrite),
                    frames=frames or None, on_progress=report, stop=stop,
                )  # fmt: skip
            except VidstyleError as error:
                await self._tell("render", 0, None, error=str(error), finished=True)
                raise
        text = "cancelled" if summary.stopped else ""
        done = summary.frames
        await self._tell("render", done, done, file=str(path), text=text, finished=True)

    async def steady(self, page: PageConnection, frames: FrameSender) -> None:
        """Send one second of the clip, rendered with temporal smoothing, to a browser.

        Args:
            frames: sends the frames of this browser.

        Raises:
            UsageError: no style is open, or another job is running.
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
                    await self._tell("steady", done, count, finished=False)
            finally:
                await session.picture(_close, made)
        await self._tell("steady", done, done, finished=True)

    async def _tell(self, kind: str, done: int, total: int | None, **fields: Any) -> None:
        await self._tell_all({"progress": {"kind": kind, "done": done, "total": total, **fields}})


def _close(made: Iterator[Any]) -> None:
    made.close()  # type: ignore[attr-defined]
