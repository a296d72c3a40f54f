"""What one browser of the designer is shown: the state of the document, plans, frames and clips."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from vidstyle.design.page.design_session import DesignSession
from vidstyle.design.page.frames import FrameSender
from vidstyle.errors import StyleError, VidstyleError
from vidstyle.preview.clip import Clip
from vidstyle.preview.plans import PlanSender
from vidstyle.preview.representative import representative_frame
from vidstyle.web.changes import changes
from vidstyle.web.connection import PageConnection


class DesignView(PageConnection):
    """The sending half of a connection.

    Attributes:
        session: shared by all browsers.
        frames: sends the frames of the clip.
    """

    MAX_MESSAGES = 400
    MAX_TASKS = 10

    def __init__(self, session: DesignSession, **options: Any) -> None:
        """`options`: see `PageConnection`."""
        super().__init__(**options)
        self.session = session
        self.frames = FrameSender(session, self)
        self._state: dict[str, Any] | None = None
        self._plans = PlanSender()
        self._cue_text = ""

    def error_text(self, error: VidstyleError) -> str:
        """Return the error as one sentence; omit the subject of mistakes in a style."""
        return error.mistakes[0] if isinstance(error, StyleError) and error.mistakes else str(error)

    async def show_state(self, state: dict[str, Any] | None) -> None:
        """Send the changes of the document, and the new plan or picture."""
        before, self._state = self._state, state
        if before is None or state is None:
            await self.tell({"state": state})
        else:
            await self.tell({"changes": list(changes(before, state))})
        with suppress(VidstyleError):  # a mistake in the open style, which the state names
            await self._read_cues()
        await self.show_style()

    async def show_cues(self, text: str) -> None:
        """Show the film in the styles of a cue file; with an empty text, in the open style.

        Raises:
            InputError: the text has mistakes.
        """
        self._cue_text = text
        await self._read_cues()
        await self.show_style()

    async def _read_cues(self) -> None:
        session, text = self.session, self._cue_text
        self.frames.shown.cues = await session.run(session.cue_list, text) if text else None

    async def show_style(self) -> None:
        """Send the plan of the shown style, or render it on the server."""
        style, shown = self.frames.style, self.frames.shown
        if style is None:
            return
        if self.frames.is_rendering:
            self.frames.restyle()
            return
        clip, revision = self.session.designer.clip, self.session.revision
        try:
            height, width = (await self.session.run(clip.frame, shown.number, shown.side)).shape[:2]
            message = await self.session.run(self._plans.message, style, width, height)
        except VidstyleError as error:
            await self.tell({"notice": self.error_text(error)})
            return
        purpose = "solo" if shown.solo is not None else "main"
        await self.tell({"plan": {"for": purpose, "revision": revision} | message})
        self.frames.restyle()

    async def show_clip(self, clip: Clip) -> None:
        """Show another clip."""
        self.frames.stop()
        message = await self.session.run(clip_message, clip)
        self.frames.shown.number = message["start"]
        await self.tell({"clip": message})
        await self.show_style()
        await self.frames.send()


def clip_message(clip: Clip) -> dict[str, Any]:
    """Return the message that describes a clip."""
    facts = {"name": clip.name, "size": clip.size, "count": clip.count, "fps": clip.fps, "live": clip.live}
    return facts | {"start": representative_frame(clip)}
