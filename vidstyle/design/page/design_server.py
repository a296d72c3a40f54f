"""The web server of the designer: one style, shown in one or more browsers."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from aiohttp import web

import vidstyle.web
from vidstyle.blocks import all_blocks
from vidstyle.design.designer import Designer
from vidstyle.design.page.frames import PictureType
from vidstyle.design.page.jobs import Jobs
from vidstyle.design.page.page_connection import PageConnection
from vidstyle.design.restyling import Restyler, StepPictures
from vidstyle.design.samples import block_sample, style_sample
from vidstyle.errors import InputError, OutputError, StyleError
from vidstyle.export import RUNNER_FOLDER
from vidstyle.preview.clip import Clip
from vidstyle.preview.encode import encode
from vidstyle.style import load_style, style_names

STATIC_FOLDER = Path(__file__).parent.with_name("static")
MAX_PAGES = 3
STEP_THUMBNAIL_PX = 120
"""Shorter side of the thumbnails of steps."""
SETTLED_SECONDS = 0.12
"""Time without an edit after which the thumbnails of steps are updated."""


class DesignServer:
    """Serves a designer. All coroutines run in the server's event loop.

    Attributes:
        url, one_time_url: see `WebServer`.
        designer: the open style and clip.
        pages: the connected browsers.
        restyler: renders previews.
        jobs: runs long jobs.
    """

    def __init__(self, designer: Designer, port: int = 0, device: str = "auto") -> None:
        """Start serving.

        Args:
            port: port to listen on; 0 selects a free one.
            device: renders for browsers that cannot, see `open_renderer`.

        Raises:
            OutputError: the port is taken or needs privileges.
        """
        self.designer = designer
        self.pages: list[PageConnection] = []
        self.restyler, self.jobs = Restyler(device), Jobs(self)
        self._steps = StepPictures()
        self._work = ThreadPoolExecutor(1, "vidstyle design")
        self._pictures = ThreadPoolExecutor(1, "vidstyle design pictures")
        self._samples: dict[str, asyncio.Future[bytes]] = {}
        self._settling: asyncio.Task[None] | None = None
        self._fault: BaseException | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        handlers = {
            "/socket": self._serve_socket,
            "/style.jpg": self._send_sample(style_names, style_sample),
            "/block.jpg": self._send_sample(all_blocks, block_sample),
        }
        try:
            self._server = vidstyle.web.WebServer(
                "vidstyle designer", handlers, [STATIC_FOLDER, RUNNER_FOLDER], "index.html", port
            )
        except OSError as error:
            reason = error.strerror or str(error)
            raise OutputError("designer", f"port {port}: {reason}", "give another with --port") from error
        self.url, self.one_time_url = self._server.url, self._server.one_time_url

    @property
    def error(self) -> BaseException | None:
        """The exception that ended the server (a bug in this program), or None."""
        return self._fault or self._server.error

    def close(self) -> None:
        """Save a draft of unsaved changes, and stop."""
        self.jobs.cancel()
        self._server.submit(self._end_tasks)
        self._server.close()
        self._work.shutdown()
        self._pictures.shutdown()
        self.designer.keep_draft()
        self.restyler.close()
        self._steps.close()
        self.designer.clip.close()

    def begin(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Run a coroutine in the background; an exception in it ends the designer."""

        async def watched() -> None:
            try:
                await work
            except Exception as error:
                self._fault = error

        task = asyncio.get_running_loop().create_task(watched())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _end_tasks(self) -> None:
        for task in self._tasks:
            task.cancel()

    async def run(self, function: Callable[..., Any], *values: Any) -> Any:
        """Call a function that uses the document or the clip, one at a time."""
        return await asyncio.get_running_loop().run_in_executor(self._work, function, *values)

    async def picture(self, function: Callable[..., Any], *values: Any) -> Any:
        """Call a function that renders pictures, one at a time."""
        return await asyncio.get_running_loop().run_in_executor(self._pictures, function, *values)

    def greeting(self) -> Iterator[dict[str, Any]]:
        """Yield the initial messages for a browser, except the state."""
        yield {
            "blocks": [
                {"name": name, "kind": block.kind, "help": block.help, "picture": f"/block.jpg?of={name}"}
                for name, block in all_blocks().items()
            ]
        }
        yield {"styles": [_describe_style(name) for name in style_names()]}
        yield {"clip": clip_message(self.designer.clip)}

    async def tell(self, message: dict[str, Any]) -> None:
        """Send a message to all browsers."""
        for page in list(self.pages):
            await page.tell(message)

    async def changed(self) -> None:
        """Send the changed document and its pictures to all browsers."""
        state = await self.run(lambda: self.designer.state)
        for page in list(self.pages):
            await page.show_state(state)
        self.refresh_steps()

    async def change_clip(self, clip: Clip) -> None:
        """Show another clip."""
        old, self.designer.clip = self.designer.clip, clip
        for page in list(self.pages):
            await page.show_clip(clip)
        await self.run(old.close)
        self.refresh_steps()

    def refresh_steps(self) -> None:
        """Update the thumbnails of steps and save a draft, once edits pause."""
        if self._settling is not None:
            self._settling.cancel()
        self._settling = self.begin(self._send_steps())

    async def _send_steps(self) -> None:
        await asyncio.sleep(SETTLED_SECONDS)
        document = self.designer.document
        if document is None or not self.pages:
            return
        number = self.pages[0].number  # the last browser may disconnect during the calls below
        await self.run(self.designer.keep_draft)
        revision, style, content = document.revision, document.style, document.content
        if document.mistakes:
            return
        clip = self.designer.clip
        try:
            made = await self.picture(lambda: self._steps.of(style, clip.frame(number, STEP_THUMBNAIL_PX)))
        except (StyleError, InputError):  # reported by the full-size preview
            return
        for (layer, place), picture in made.items():
            data = await self.picture(encode, picture, "jpeg")
            for page in list(self.pages):
                await page.send_picture(PictureType.STEP, content.layers[layer][place].number, revision, data)

    def _send_sample(
        self, names: Callable[[], Any], make: Callable[[str], bytes]
    ) -> Callable[[web.Request], Any]:
        async def handler(request: web.Request) -> web.StreamResponse:
            name = request.query.get("of", "")
            if name not in names():
                raise web.HTTPNotFound
            key = f"{request.path} {name}"
            if key not in self._samples:
                self._samples[key] = asyncio.ensure_future(self.picture(make, name))
            try:
                data = await asyncio.shield(self._samples[key])
            except StyleError as error:  # an invalid style file of the user
                raise web.HTTPNotFound from error
            return web.Response(body=data, content_type="image/jpeg")

        return handler

    async def _serve_socket(self, request: web.Request) -> web.StreamResponse:
        return await self._server.serve(request, PageConnection(self), self.pages, MAX_PAGES)


def clip_message(clip: Clip) -> dict[str, Any]:
    """Return the message that describes a clip."""
    return {"name": clip.name, "size": clip.size, "count": clip.count, "fps": clip.fps, "live": clip.live}


def _describe_style(name: str) -> dict[str, str]:
    try:
        note = load_style(name).note
    except StyleError as error:
        note = str(error)
    return {"name": name, "note": note, "picture": f"/style.jpg?of={name}"}
