"""Films that are rendered one after another; all browsers see the queue."""

from __future__ import annotations

import asyncio
import re
import threading
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from vidstyle.cues.cue_list import CueList
from vidstyle.design.page.design_session import DesignSession
from vidstyle.errors import UsageError, VidstyleError
from vidstyle.media.read.file_structure.headers import has_picture_ending
from vidstyle.media.write.run_record import record_path
from vidstyle.media.write.temporary_files import partial_path
from vidstyle.preview.clip import Clip
from vidstyle.preview.outputs import file_of, output_path
from vidstyle.style import Style
from vidstyle.web.background_tasks import BackgroundTasks
from vidstyle.web.rendered_files import RENDERED_PATH

if TYPE_CHECKING:
    from vidstyle.pipeline.progress import Progress

MAX_LISTED_JOBS = 50
"""Number of jobs that the queue lists; the oldest finished ones are dropped first."""


@dataclass
class RenderJob:
    """A film or photograph to render.

    Attributes:
        source: the file to read.
        frames: the number of frames to render; None for all.
        text: the pace while it runs, and its error afterwards.
        error: what ended it, if it failed.
        partial: the file with the finished part of a stopped job.
        resumes: whether it continues that file.
    """

    number: int
    clip: Clip
    source: str
    path: Path
    style: Style | CueList
    frames: int | None
    overwrite: bool
    state: Literal["waiting", "rendering", "done", "stopped", "failed"] = "waiting"
    done: int = 0
    total: int | None = None
    text: str = ""
    error: VidstyleError | None = None
    partial: Path | None = None
    resumes: bool = False
    stop: threading.Event = field(default_factory=threading.Event)

    @property
    def is_over(self) -> bool:
        return self.state not in ("waiting", "rendering")

    @property
    def made_file(self) -> Path | None:
        """The file that the job wrote; None until it is done, and once the file is removed."""
        return self.path if self.state == "done" and self.path.is_file() else None

    def describe(self) -> dict[str, Any]:
        """Return what the page shows of it."""
        shown = {name: getattr(self, name) for name in ("number", "state", "done", "total", "text")}
        names = {"file": self.path.name, "folder": str(self.path.parent), "style": self.style.name}
        address = f"{RENDERED_PATH}?of={self.number}" if self.made_file else ""
        kind = {"source": Path(self.clip.name).name, "is_picture": has_picture_ending(self.path)}
        partial = self.partial.name if self.partial is not None and self.partial.is_file() else ""
        return shown | names | kind | {"address": address, "partial": partial}


class RenderQueue:
    """Runs one job after another, and reports progress to all browsers."""

    def __init__(
        self,
        session: DesignSession,
        tasks: BackgroundTasks,
        tell: Callable[[dict[str, Any]], Awaitable[None]],
    ) -> None:
        """Prepare an empty queue.

        Args:
            tasks: runs the jobs, whichever browsers disconnect.
            tell: sends a message to all browsers.
        """
        self._session, self._tasks, self._tell = session, tasks, tell
        self._jobs: list[RenderJob] = []
        self._numbers, self._turn = count(1), asyncio.Lock()
        self._clips: Counter[Clip] = Counter()
        self._leaving: list[Clip] = []

    @property
    def message(self) -> dict[str, Any]:
        """The message that describes the queue."""
        return {"queue": [job.describe() for job in self._jobs]}

    def cancel(self) -> None:
        """Stop the current job; waiting jobs continue."""
        for job in self._jobs:
            if job.state == "rendering":
                job.stop.set()

    def end(self) -> None:
        """Stop all jobs."""
        for job in self._jobs:
            job.stop.set()

    async def stop(self, number: int) -> None:
        """Stop a job, or take it out of the queue.

        Raises:
            UsageError: there is no such job.
        """
        job = self.job(number)
        job.stop.set()
        if job.state == "waiting":
            job.state = "stopped"
        await self._tell(self.message)

    async def resume(self, number: int) -> None:
        """Continue a stopped job after all others.

        Raises:
            UsageError: there is no such job.
        """
        job = self.job(number)
        if job.state != "stopped":
            return
        job.state, job.stop, job.resumes = "waiting", threading.Event(), job.partial is not None
        self._clips[job.clip] += 1
        await self._tell(self.message)
        self._tasks.begin(self._work(job))

    async def remove(self, number: int) -> None:
        """Drop a job that did not finish from the list, and remove its partial file.

        Raises:
            UsageError: there is no such job.
        """
        job = self.job(number)
        if job.state not in ("stopped", "failed"):
            return
        self._jobs.remove(job)
        if job.partial is not None:
            for path in (job.partial, record_path(job.path)):
                await asyncio.to_thread(path.unlink, missing_ok=True)
        await self._tell(self.message)

    def job(self, number: int) -> RenderJob:
        """Return a job by its number.

        Raises:
            UsageError: there is no such job.
        """
        for job in self._jobs:
            if job.number == number:
                return job
        raise UsageError("the queue", f"has no job {number}")

    def finished(self, number: int) -> Path | None:
        """Return the file of a finished job; None for other numbers, and for a file that was removed."""
        return next((job.made_file for job in self._jobs if job.number == number), None)

    async def release(self, clip: Clip) -> None:
        """Close a clip once no job needs its file."""
        if self._clips[clip]:
            self._leaving.append(clip)
        else:
            await self._session.run(clip.close)

    async def render(self, name: str, overwrite: bool, frames: int | None, style: Style | CueList) -> str:
        """Render the clip to a file in the working folder, after all earlier jobs; return its path.

        Args:
            name: of the file; empty for one from the names of clip and style that does not exist yet.

        Raises:
            UsageError: the name is invalid or exists, or the clip is a camera.
            VidstyleError: rendering failed.
        """
        designer = self._session.designer
        clip = designer.clip
        source = await self._session.run(file_of, clip)
        path = self._free_path(clip, style) if not name else output_path(designer.folder, name, "", overwrite)
        if any(job.path == path for job in self._jobs if not job.is_over):
            raise UsageError(path.name, "is already in the queue", "choose another name")
        job = RenderJob(next(self._numbers), clip, source, path, style, frames or None, overwrite)
        self._jobs = self._pruned() + [job]
        self._clips[clip] += 1
        await self._tell(self.message)
        await asyncio.shield(self._tasks.begin(self._work(job)))
        if job.error is not None:
            raise job.error
        return str(path)

    def _free_path(self, clip: Clip, style: Style | CueList) -> Path:
        stem = re.sub(r"[^\w-]+", "-", f"{Path(clip.name).stem}-{style.name}").strip("-")[:80] or "film"
        suffix = ".png" if clip.count == 1 else ".mp4"
        taken = {job.path for job in self._jobs if not job.is_over}
        names = (f"{stem}{'' if number == 1 else f'-{number}'}{suffix}" for number in count(1))
        paths = (self._session.designer.folder / name for name in names)
        return next(path for path in paths if path not in taken and not _exists(path))

    def _pruned(self) -> list[RenderJob]:
        over = [job for job in self._jobs if job.is_over]
        dropped = over[: max(0, len(self._jobs) + 1 - MAX_LISTED_JOBS)]
        return [job for job in self._jobs if job not in dropped]

    async def _work(self, job: RenderJob) -> None:
        try:
            async with self._turn:
                if not job.stop.is_set():
                    await self._render(job)
        finally:
            self._clips[job.clip] -= 1
            if job.clip in self._leaving and not self._clips[job.clip]:
                self._leaving.remove(job.clip)
                await self._session.run(job.clip.close)

    async def _render(self, job: RenderJob) -> None:
        from vidstyle.media.write.writer import WriteOptions
        from vidstyle.pipeline.render import render

        loop = asyncio.get_running_loop()

        def report(progress: Progress) -> None:
            job.done, job.total, job.text = progress.frames, progress.total_frames, progress.pace_text
            asyncio.run_coroutine_threadsafe(self._show(job), loop)

        job.state = "rendering"
        await self._show(job)
        try:
            summary = await asyncio.to_thread(
                render, job.source, job.path, job.style, write=WriteOptions(overwrite=job.overwrite),
                frames=job.frames, on_progress=report, stop=job.stop, resume=job.resumes,
            )  # fmt: skip
        except VidstyleError as error:
            job.error, job.text, job.state = error, str(error), "failed"
        else:
            job.state = "stopped" if summary.stopped else "done"
            job.partial = summary.partial
            job.done, job.text = summary.frames, "cancelled" if summary.stopped else ""
        await self._show(job)

    async def _show(self, job: RenderJob) -> None:
        """Report the progress of a job and the queue to all browsers."""
        ends = {"done": {"file": str(job.path)}, "failed": {"error": job.text}}
        fields = {"text": job.text, "finished": job.is_over, **ends.get(job.state, {})}
        total = job.done if job.is_over else job.total
        progress = {"kind": "render", "done": job.done, "total": total, **fields}
        await self._tell({"progress": progress})
        await self._tell(self.message)


def _exists(path: Path) -> bool:
    """Whether there is a file, or what an interrupted run has left of it."""
    return path.exists() or partial_path(path).exists()
