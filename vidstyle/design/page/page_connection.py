"""The connection to one browser that shows the designer: dispatch its messages and send its pictures."""

from __future__ import annotations

import asyncio
import json
import struct
from collections.abc import Awaitable, Callable, Coroutine
from typing import TYPE_CHECKING, Any

from aiohttp import web

from vidstyle.design.document.solo import solo
from vidstyle.design.page.frames import FrameSender
from vidstyle.design.page.message_fields import MESSAGE_FIELDS
from vidstyle.design.page.page_actions import ACTIONS
from vidstyle.design.page.uploads import FileUpload
from vidstyle.errors import StyleError, VidstyleError
from vidstyle.preview.clip import Clip
from vidstyle.preview.plans import PlanSender
from vidstyle.style import Style
from vidstyle.web.changes import changes
from vidstyle.web.messages import MessageError, RateLimit, read_message, receive, refuse

if TYPE_CHECKING:
    from vidstyle.design.page.design_server import DesignServer

MAX_MESSAGES = 400
"""Maximum messages per second; chunks of uploads are not counted."""
MAX_TASKS = 8
"""Maximum number of background tasks."""
PICTURE_HEADER = struct.Struct(">B3xIQ")
"""Header of a picture: its type, a number, and the revision of the document."""


class PageConnection:
    """Serves one WebSocket until it closes.

    Attributes:
        server: the server of all connections.
        solo: the number of the soloed step, or None.
        side: the shorter side of the preview in pixels.
        where: the renderer, "page" or "server".
        frames: sends the frames of the clip.
        upload: the upload in progress, or None.
    """

    def __init__(self, server: DesignServer) -> None:
        self.server = server
        self.solo: int | None = None
        self.side, self.where = 360, "page"
        self.frames = FrameSender(self)
        self.upload: FileUpload | None = None
        self._state: dict[str, Any] | None = None
        self._plans = PlanSender()
        self._tasks: set[asyncio.Task[None]] = set()
        self._limit = RateLimit(MAX_MESSAGES, asyncio.get_running_loop().time)

    @property
    def number(self) -> int:
        """The number of the current frame."""
        return self.frames.number

    @property
    def style(self) -> Style | None:
        """The style that the browser shows, reduced to the soloed step if any; None if no style is open."""
        document = self.server.designer.document
        if document is None:
            return None
        places = {step.number: (layer, place) for layer, place, step in document.content.steps}
        if self.solo in places and not document.mistakes:
            return solo(document.style, *places[self.solo])
        return document.style

    async def serve(self, socket: web.WebSocketResponse) -> None:
        """Send the initial messages, then dispatch messages until the socket closes."""
        self._socket = socket
        invalid = None
        try:
            await self._greet()
            invalid = await receive(socket, self._handle)
        except ConnectionError:  # the browser disconnected without closing the socket
            pass
        finally:
            self.frames.stop()
            for task in self._tasks:
                task.cancel()
            if self.upload is not None:
                self.upload.drop()
        if invalid is not None:
            await refuse(socket, invalid)

    async def tell(self, message: dict[str, Any]) -> None:
        """Send a message, unless the browser has disconnected."""
        try:
            await self._socket.send_str(json.dumps(message))
        except ConnectionError:
            pass

    async def send_picture(self, kind: int, number: int, revision: int, data: bytes) -> None:
        """Send a picture, encoded as PNG or JPEG, unless the browser has disconnected."""
        try:
            await self._socket.send_bytes(PICTURE_HEADER.pack(kind, number, revision) + data)
        except ConnectionError:
            pass

    async def show_state(self, state: dict[str, Any] | None) -> None:
        """Send the changes of the document, and the new plan or picture."""
        before, self._state = self._state, state
        if before is None or state is None:
            await self.tell({"state": state})
        else:
            await self.tell({"changes": list(changes(before, state))})
        await self.show_style()

    async def show_style(self) -> None:
        """Send the plan of the shown style, or render it on the server."""
        style = self.style
        if style is None:
            return
        if self.where == "server":
            self.frames.restyle()
            return
        clip = self.server.designer.clip
        try:
            height, width = (await self.server.run(clip.frame, self.number, self.side)).shape[:2]
            message = await self.server.run(self._plans.message, style, width, height)
        except VidstyleError as error:
            await self.tell({"notice": _error_text(error)})
            return
        await self.tell({"plan": {"for": "solo" if self.solo is not None else "main"} | message})

    async def show_clip(self, clip: Clip) -> None:
        """Show another clip."""
        from vidstyle.design.page.design_server import clip_message

        self.frames.stop()
        self.frames.number = 0
        await self.tell({"clip": clip_message(clip)})
        await self.show_style()
        await self.frames.send()

    def begin(self, work: Coroutine[Any, Any, None]) -> None:
        """Run a coroutine in the background; cancel it when the browser disconnects."""
        task = self.server.begin(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    @property
    def is_busy(self) -> bool:
        """Whether the maximum number of background tasks is running."""
        return len(self._tasks) >= MAX_TASKS

    async def answer(self, id: int, work: Callable[[], Awaitable[dict[str, Any] | None]]) -> None:
        """Answer a message with the result of `work`, or with its error message."""
        try:
            answer = await work() or {}
        except VidstyleError as error:
            answer = {"error": _error_text(error)}
        await self.tell({"answer": id} | answer)

    async def _greet(self) -> None:
        for message in await self.server.run(lambda: list(self.server.greeting())):
            await self.tell(message)
        await self.show_state(await self.server.run(lambda: self.server.designer.state))
        await self.tell({"draft": await self.server.run(lambda: self.server.designer.draft_offer)})
        self.server.refresh_steps()

    async def _handle(self, data: str | bytes) -> None:
        if isinstance(data, bytes):
            if self.upload is None:
                raise MessageError("a chunk without an upload")
            await self.upload.take(data)
            return
        self._limit.count()
        message = read_message(data, MESSAGE_FIELDS)
        kind, id = message.pop("do"), message.pop("id")
        await ACTIONS[kind](self, id, message)


def _error_text(error: VidstyleError) -> str:
    """Return the error as one sentence; omit the subject of mistakes in a style."""
    return error.mistakes[0] if isinstance(error, StyleError) and error.mistakes else str(error)
