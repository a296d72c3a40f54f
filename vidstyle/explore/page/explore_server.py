"""The web server of the explorer, and the messages of its page."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

from vidstyle.errors import UsageError
from vidstyle.explore.generate import LOCKS
from vidstyle.explore.page.descriptions import describe_clip, describe_state
from vidstyle.explore.page.exploration import Exploration
from vidstyle.explore.page.pictures import PICTURE_SIDES_PX, picture_handlers
from vidstyle.explore.page.saving import save_style_of_user
from vidstyle.export.export_style import export_style
from vidstyle.preview.outputs import ExportKind, JobSlot, file_of, output_path
from vidstyle.preview.uploads import FileUpload, UploadReceiver
from vidstyle.style import Style
from vidstyle.web.connection import PageConnection
from vidstyle.web.messages import Answer, FractionField, integer_between, message, one_of
from vidstyle.web.page_server import PageServer
from vidstyle.web.rendered_files import RENDERED_PATH, RenderedFiles

STATIC_FOLDER = Path(__file__).with_name("static")
MAX_BROWSERS = 4
MAX_REFERENCE_BYTES = 1 << 28
FILM_SUFFIX, PICTURE_SUFFIX = ".mp4", ".png"

PictureSide = Annotated[int, one_of(PICTURE_SIDES_PX)]
ReferenceSize = Annotated[int, integer_between(1, MAX_REFERENCE_BYTES)]
LockName = Annotated[str, one_of(LOCKS)]

OpenDesigner = Callable[[str | None, Style], str]
"""Opens the designer on a source with a style; returns its URL."""


class ExploreServer(PageServer["ExploreConnection"]):
    """Serves the page until it is closed.

    Attributes:
        exploration: the exploration; closed with the server.
        designer: opens the designer, if available.
        reveal: shows a file in its folder; None without a desktop.
        written: the files that the page has written.
        job: the film that is rendered, if any.
        tried: the progress of the screen that is being made: its step, how much is done, of how much, and
            the number of candidates to be seen.
    """

    def __init__(
        self,
        exploration: Exploration,
        port: int = 0,
        designer: OpenDesigner | None = None,
        reveal: Callable[[Path], None] | None = None,
    ) -> None:
        """Open the page.

        Args:
            port: port to listen on; 0 selects a free one.

        Raises:
            OutputError: the port is taken or needs privileges.
        """
        self.exploration, self.designer, self.job = exploration, designer, JobSlot()
        self.reveal, self.written = reveal, set[Path]()
        self.rendered: list[Path] = []
        self._folders: list[TemporaryDirectory[str]] = []
        super().__init__(
            "page", lambda: ExploreConnection(self),
            picture_handlers(exploration) | {RENDERED_PATH: RenderedFiles(self._rendered_file).serve},
            STATIC_FOLDER, "explore.html", most=MAX_BROWSERS, port=port,
        )  # fmt: skip
        self.tried: dict[str, Any] = {"step": "trying styles", "done": 0, "total": 0, "shown": 0}
        exploration.on_progress = lambda step, done, total: self.submit(self._report, step, done, total)
        threading.Thread(target=self._begin, name="vidstyle first screen", daemon=True).start()

    def _rendered_file(self, number: int) -> Path | None:
        return self.rendered[number] if number < len(self.rendered) else None

    def pictures_folder(self) -> Path:
        """Return a new folder for a picture, which is deleted with the server."""
        self._folders.append(TemporaryDirectory(prefix="vidstyle-"))
        return Path(self._folders[-1].name)

    def close(self) -> None:
        """Cancel rendering and close the server."""
        self.job.cancel()
        self.exploration.close()
        super().close()
        for folder in self._folders:
            folder.cleanup()

    async def _report(self, step: str, done: float, total: float) -> None:
        shown = len(self.exploration.tries)
        self.tried = {"step": step, "done": done, "total": total, "shown": shown}
        await self.tell({"tried": self.tried})

    def _begin(self) -> None:
        try:
            self.exploration.begin()
        except Exception as error:
            self.fail(error)
        self.submit(self.send_state)

    def clip(self) -> dict[str, Any]:
        """See `describe_clip`."""
        return describe_clip(self.exploration, self.designer is not None, self.reveal is not None)

    def state(self) -> dict[str, Any]:
        """See `describe_state`."""
        return describe_state(self.exploration)

    async def send_state(self) -> None:
        """Send the state to all browsers."""
        await self.tell({"state": self.state()})

    async def choose(self, action: Callable[..., Any], *values: Any) -> Any:
        """Call a method of the exploration, then send the state, even if the browser has disconnected."""
        self.exploration.stopped.clear()

        def work() -> Any:
            result = action(*values)
            self.submit(self.send_state)
            return result

        return await asyncio.to_thread(work)


class ExploreConnection(PageConnection):
    """Serves one WebSocket until it closes."""

    def __init__(self, server: ExploreServer) -> None:
        super().__init__(fail=server.fail)
        self._server, self._exploration = server, server.exploration
        self._sent: set[str] = set()
        self._uploads = UploadReceiver()

    async def greet(self) -> None:
        """Send the clip and the state."""
        await self.tell({"clip": self._server.clip()})
        await self.tell({"state": self._server.state()})
        await self.tell({"tried": self._server.tried})

    def leave(self) -> None:
        """Drop the upload."""
        self._uploads.drop()

    def _style(self, tile: int) -> Style:
        return self._exploration.tile(tile).style

    # A reference picture

    @message
    async def upload(self, id: int, name: str, size: ReferenceSize) -> None:
        """Announce a reference picture, which follows in binary messages; the last one is answered too."""
        self._uploads.announce(id, name, size)

    async def take_bytes(self, data: bytes) -> None:
        """Take a chunk of the reference; show matching styles after the last one, and answer the upload."""
        upload = await self._uploads.take(data)
        if upload is not None:
            self.tasks.begin(self.answer(upload.id, lambda: self._match(upload)))

    async def _match(self, upload: FileUpload) -> None:
        await self._server.choose(self._exploration.match, await asyncio.to_thread(upload.read_picture))

    # Choices, after which all browsers get the new state

    @message(in_background=True)
    async def like(self, tile: int) -> None:
        await self._server.choose(self._exploration.more_like, tile)

    @message(in_background=True)
    async def again(self) -> None:
        await self._server.choose(self._exploration.again)

    @message(in_background=True)
    async def fresh(self) -> None:
        await self._server.choose(self._exploration.new_screen)

    @message(in_background=True)
    async def back(self) -> None:
        await self._server.choose(self._exploration.back)

    @message(in_background=True)
    async def forward(self) -> None:
        await self._server.choose(self._exploration.forward)

    @message(in_background=True)
    async def jump(self, screen: int) -> None:
        await self._server.choose(self._exploration.jump, screen)

    @message(in_background=True)
    async def near(self, part: FractionField) -> None:
        await self._server.choose(self._exploration.set_near, part)

    @message(in_background=True)
    async def lock(self, name: LockName, on: bool) -> None:
        await self._server.choose(self._exploration.lock, name, on)

    @message(in_background=True)
    async def star(self, tile: int, on: bool) -> None:
        await self._server.choose(self._exploration.star, tile, on)

    @message(in_background=True)
    async def move(self, part: FractionField) -> Answer:
        await self._server.choose(self._exploration.move_to, part)
        return {"clip": self._server.clip()}

    @message(in_background=True)
    async def keep(self, tile: int, x: FractionField, y: FractionField) -> Answer:
        return {"tile": await self._server.choose(self._exploration.tuned, tile, x, y)}

    # Plans

    @message(in_background=True)
    async def plan(self, tile: int, side: PictureSide, whole: bool) -> Answer:
        return await self._plan(self._style(tile), side, whole)

    @message(in_background=True)
    async def pad(self, tile: int) -> Answer:
        pad = await asyncio.to_thread(self._exploration.pad, tile)
        axes = [{"label": axis.label, "path": axis.path, "low": axis.low, "high": axis.high,
                 "whole": axis.is_whole, "factor": axis.is_factor} for axis in pad.axes]  # fmt: skip
        return {"axes": axes, "start": pad.start}

    @message(in_background=True)
    async def tune(
        self, tile: int, x: FractionField, y: FractionField, side: PictureSide, whole: bool
    ) -> Answer:
        pad = await asyncio.to_thread(self._exploration.pad, tile)
        return await self._plan(pad.style_at(x, y), side, whole)

    async def _plan(self, style: Style, side: int, whole: bool) -> Answer:
        """Return the plan of a style; only its values if the browser has it, unless it requests the whole."""
        plan = await asyncio.wrap_future(self._exploration.plan(style, side))
        if plan["key"] in self._sent and not whole:
            return {name: plan[name] for name in ("key", "values")}
        self._sent.add(plan["key"])
        return plan

    # Files

    @message(in_background=True)
    async def save(self, tile: int, name: str, overwrite: bool) -> Answer:
        path = await asyncio.to_thread(save_style_of_user, self._style(tile), name, overwrite)
        return self._answer_file(path)

    def _answer_file(self, path: Path, **more: int) -> Answer:
        self._server.written.add(path)
        return {"file": str(path), **more}

    @message(in_background=True)
    async def reveal(self, file: str) -> None:
        """Show a file that the page has written in its folder."""
        path, reveal = Path(file), self._server.reveal
        if reveal is None or path not in self._server.written:
            raise UsageError(file, "cannot be shown from here", "open its folder yourself")
        await asyncio.to_thread(reveal, path)

    @message(in_background=True)
    async def export(self, tile: int, name: str, kind: ExportKind) -> Answer:
        path = output_path(Path.cwd(), name, f".{kind}")
        await asyncio.to_thread(export_style, replace(self._style(tile), name=path.stem), path)
        return self._answer_file(path)

    @message(in_background=True)
    async def render(self, tile: int, name: str) -> Answer:
        """Answer with the file, and with its number under `RENDERED_PATH`."""
        path = await asyncio.to_thread(self._render, self._style(tile), name)
        self._server.rendered.append(path)
        return self._answer_file(path, number=len(self._server.rendered) - 1)

    def _render(self, style: Style, name: str) -> Path:
        from vidstyle.pipeline.render import render

        clip, submit = self._exploration.clip, self._server.submit
        is_film = clip.count > 1
        # A picture goes to the downloads of the browser, as on the other pages.
        folder = Path.cwd() if is_film else self._server.pictures_folder()
        path = output_path(folder, name, FILM_SUFFIX if is_film else PICTURE_SUFFIX)
        with self._server.job.begin() as stop:
            render(
                file_of(clip), path, style, stop=stop,
                on_progress=lambda progress: submit(self._server.tell, {"progress": progress.as_dict()}),
            )  # fmt: skip
        return path

    @message(in_background=True)  # in the order of the messages: after the choice that it stops
    async def stop(self) -> None:
        """Stop the search for the next screen."""
        self._exploration.stop()

    @message
    async def cancel(self) -> None:
        """Stop rendering."""
        self._server.job.cancel()

    @message(in_background=True)
    async def design(self, tile: int) -> Answer:
        if self._server.designer is None:
            raise UsageError("designer", "cannot be opened from here")
        source = self._exploration.clip.file()
        return {"url": await asyncio.to_thread(self._server.designer, source, self._style(tile))}
