"""Long jobs with progress and cancellation: render the film, or one second with temporal smoothing."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vidstyle.design.page.frames import PictureType
from vidstyle.design.restyling import render_second
from vidstyle.errors import UsageError, VidstyleError
from vidstyle.preview.encode import encode
from vidstyle.preview.places import checked_path, refuse_existing

if TYPE_CHECKING:
    from vidstyle.design.page.design_server import DesignServer
    from vidstyle.design.page.page_connection import PageConnection
    from vidstyle.pipeline.progress import Progress

MAX_STEADY_SIDE_PX = 270
"""Maximum shorter side of the pictures of `Jobs.steady`."""


class Jobs:
    """Runs one job at a time."""

    def __init__(self, server: DesignServer) -> None:
        self._server = server
        self._stop: threading.Event | None = None

    def cancel(self) -> None:
        """Cancel the current job, if any."""
        if self._stop is not None:
            self._stop.set()

    async def render(self, name: str, overwrite: bool, frames: int | None) -> None:
        """Render the clip to a file in the working folder, and report progress to all browsers.

        Raises:
            UsageError: the name is invalid or exists, no style is open, or the clip is a camera.
            VidstyleError: rendering failed.
        """
        from vidstyle.media.write.writer import WriteOptions
        from vidstyle.pipeline.render import render

        designer, loop = self._server.designer, asyncio.get_running_loop()
        path = checked_path(designer.folder, name)
        refuse_existing(path, overwrite)
        style = designer.opened.valid_style()
        source = await self._server.run(designer.clip.file)
        if source is None:
            raise UsageError(designer.clip.name, "is no film", "record it with vidstyle live")
        stop = self._begin()

        def report(progress: Progress) -> None:
            asyncio.run_coroutine_threadsafe(self._tell(_progress_fields(progress)), loop)

        def work() -> Any:
            write = WriteOptions(overwrite=overwrite)
            return render(
                source, path, style, write=write, frames=frames or None, on_progress=report, stop=stop
            )

        try:
            summary = await asyncio.to_thread(work)
        except VidstyleError as error:
            await self._tell({"kind": "render", "error": str(error), "finished": True})
            raise
        finally:
            self._stop = None
        text = "cancelled" if summary.stopped else ""
        last = {"done": summary.frames, "total": summary.frames, "text": text, "finished": True}
        await self._tell({"kind": "render", "file": path.name} | last)

    async def steady(self, page: PageConnection) -> None:
        """Send one second of the clip, rendered with temporal smoothing, to a browser.

        Raises:
            UsageError: no style is open, or another job is running.
        """
        style = self._server.designer.opened.valid_style()
        stop, clip = self._begin(), self._server.designer.clip
        made = render_second(style, clip, page.number, min(page.side, MAX_STEADY_SIDE_PX), stop.is_set)
        try:
            revision = self._server.designer.opened.revision
            done = 0
            while (item := await self._server.picture(next, made, None)) is not None:
                number, count, picture = item
                done += 1
                data = await asyncio.to_thread(encode, picture, "jpeg")
                await page.send_picture(PictureType.STEADY, number, revision, data)
                await self._tell({"kind": "steady", "done": done, "total": count, "finished": False})
        finally:
            await self._server.picture(_close, made)
            self._stop = None
        await self._tell({"kind": "steady", "done": done, "total": done, "finished": True})

    def _begin(self) -> threading.Event:
        if self._stop is not None:
            raise UsageError("the designer", "is busy with another job", "wait, or cancel it")
        self._stop = threading.Event()
        return self._stop

    async def _tell(self, progress: dict[str, Any]) -> None:
        await self._server.tell({"progress": progress})


def _close(made: Iterator[Any]) -> None:
    made.close()  # type: ignore[attr-defined]


def _progress_fields(progress: Progress) -> dict[str, Any]:
    return {
        "kind": "render",
        "done": progress.frames,
        "total": progress.total_frames,
        "speed": round(progress.rate, 2),
        "text": progress.pace_text,
        "finished": False,
    }
