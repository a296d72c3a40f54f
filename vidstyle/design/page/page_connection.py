"""One browser that shows the designer: its messages are dispatched, and it is sent what it watches."""

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
"""Messages a second; parts of a dropped file are not counted."""
MAX_TASKS = 8
"""What takes longer is done beside other messages, but no more at once."""
PICTURE_HEADER = struct.Struct(">B3xIQ")
"""In front of a picture: what it is, a number, and the revision of the document."""


class PageConnection:
    """Serves one WebSocket until it closes.

    Attributes:
        server: of all pages.
        solo, side, where: what is watched: the number of the only step that is shown or None, the shorter
            side of the picture in pixels, and whether "page" or "server" restyles.
        frames: sends the frames of the clip.
        upload: of a file that is on its way, or None.
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
        """The frame that is shown."""
        return self.frames.number

    @property
    def style(self) -> Style | None:
        """What is watched: the style, or what leaves one step of it; None while nothing is open."""
        document = self.server.designer.document
        if document is None:
            return None
        places = {step.number: (layer, place) for layer, place, step in document.content.steps}
        if self.solo in places and not document.mistakes:
            return solo(document.style, *places[self.solo])
        return document.style

    async def serve(self, socket: web.WebSocketResponse) -> None:
        """Greet the page, and dispatch its messages, until the socket closes."""
        self._socket = socket
        invalid = None
        try:
            await self._greet()
            invalid = await receive(socket, self._handle)
        except ConnectionError:  # the browser has gone without closing the socket
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
        """Send a message; nothing happens once the page has gone."""
        try:
            await self._socket.send_str(json.dumps(message))
        except ConnectionError:
            pass

    async def send_picture(self, kind: int, number: int, revision: int, data: bytes) -> None:
        """Send a picture as PNG or JPEG."""
        try:
            await self._socket.send_bytes(PICTURE_HEADER.pack(kind, number, revision) + data)
        except ConnectionError:
            pass

    async def show_state(self, state: dict[str, Any] | None) -> None:
        """Send what changed in the document, and the plan or the picture that follows from it."""
        before, self._state = self._state, state
        if before is None or state is None:
            await self.tell({"state": state})
        else:
            await self.tell({"changes": list(changes(before, state))})
        await self.show_style()

    async def show_style(self) -> None:
        """Send the plan of what is watched, or have it restyled."""
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
            await self.tell({"notice": _sentence(error)})
            return
        await self.tell({"plan": {"for": "solo" if self.solo is not None else "main"} | message})

    async def show_clip(self, clip: Clip) -> None:
        """Begin with another clip."""
        from vidstyle.design.page.design_server import clip_message

        self.frames.stop()
        self.frames.number = 0
        await self.tell({"clip": clip_message(clip)})
        await self.show_style()
        await self.frames.send()

    def begin(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something beside the next messages, at most until the page goes."""
        task = self.server.begin(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    @property
    def is_busy(self) -> bool:
        """Whether so much is done that nothing more is begun."""
        return len(self._tasks) >= MAX_TASKS

    async def answer(self, id: int, work: Callable[[], Awaitable[dict[str, Any] | None]]) -> None:
        """Answer a message with what some work gives, or with the sentence of its error."""
        try:
            answer = await work() or {}
        except VidstyleError as error:
            answer = {"error": _sentence(error)}
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
                raise MessageError("a part of no file")
            await self.upload.take(data)
            return
        self._limit.count()
        message = read_message(data, MESSAGE_FIELDS)
        kind, id = message.pop("do"), message.pop("id")
        await ACTIONS[kind](self, id, message)


def _sentence(error: VidstyleError) -> str:
    """The error in one sentence; the subject of a style's mistakes is known."""
    return error.mistakes[0] if isinstance(error, StyleError) and error.mistakes else str(error)
