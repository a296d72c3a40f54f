"""The actions of the messages from the page."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from vidstyle.design.page.frames import PictureType
from vidstyle.design.page.message_fields import EDIT_FIELDS
from vidstyle.design.page.uploads import FileUpload
from vidstyle.design.restyling import render_exactly
from vidstyle.errors import StyleError, UsageError
from vidstyle.preview.encode import encode
from vidstyle.style import load_style, style_names
from vidstyle.web.messages import MessageError

if TYPE_CHECKING:
    from vidstyle.design.page.page_connection import PageConnection

Values = dict[str, Any]
Action = Callable[["PageConnection", int, Values], Awaitable[None]]
STYLE_PREVIEW_PX = 160
"""Shorter side of the previews on the start screen."""


def _edit_action(function: Callable[[PageConnection, Values], Values | None]) -> Action:
    """Return an action that changes the document; all browsers get the change before the answer."""

    async def action(page: PageConnection, id: int, fields: Values) -> None:
        async def work() -> Values | None:
            before = page.server.designer.document
            revision = before.revision if before else None
            answer = await page.server.run(function, page, fields)
            after = page.server.designer.document
            if after is not before or (after and after.revision != revision):
                await page.server.changed()
            return answer

        await page.answer(id, work)

    return action


def _query_action(
    work: Callable[[PageConnection, Values], Awaitable[Values | None]], in_background: bool = False
) -> Action:
    """Return an action that leaves the document unchanged.

    Args:
        in_background: whether later messages are handled before it is done.
    """

    async def action(page: PageConnection, id: int, fields: Values) -> None:
        if not in_background:
            await page.answer(id, partial(work, page, fields))
        elif page.is_busy:
            await page.answer(id, _refuse)
        else:
            page.begin(page.answer(id, partial(work, page, fields)))

    return action


def _edit(kind: str) -> Action:
    def function(page: PageConnection, fields: Values) -> Values | None:
        # Two browsers, or a reloaded page, may use the same gesture numbers.
        fields["gesture"] = (id(page), fields["gesture"])
        step = page.server.designer.opened.edit(kind, **fields)
        return None if step is None else {"step": step}

    return _edit_action(function)


def _document(name: str) -> Action:
    """Return an action that calls a method of the document."""

    def function(page: PageConnection, fields: Values) -> None:
        getattr(page.server.designer.opened, name)(**fields)

    return _edit_action(function)


def _designer(name: str) -> Action:
    """Return an action that calls a method of the designer."""

    def function(page: PageConnection, fields: Values) -> None:
        getattr(page.server.designer, name)(**fields)

    return _edit_action(function)


async def _refuse() -> Values:
    raise UsageError("the designer", "is busy", "wait for the running requests")


async def _command(page: PageConnection, fields: Values) -> Values:
    return {"text": await page.server.run(page.server.designer.command)}


async def _watch(page: PageConnection, fields: Values) -> None:
    # No other message requests the frames of a camera.
    needs_frame = fields["side"] != page.side or page.server.designer.clip.live
    page.solo, page.side, page.where = fields["solo"], fields["side"], fields["where"]
    if needs_frame:
        await page.frames.send()
    await page.show_style()


async def _frame(page: PageConnection, fields: Values) -> None:
    page.frames.stop()
    page.frames.number = min(fields["number"], page.server.designer.clip.count - 1)
    await page.frames.send()
    page.server.refresh_steps()


async def _play(page: PageConnection, fields: Values) -> None:
    last = page.server.designer.clip.count - 1
    first, end = min(fields["from"], last), min(fields["to"], last)
    if not first <= fields["at"] <= end:
        fields["at"] = first
    page.frames.play(fields["at"], first, max(first, end), float(fields["fps"]))


async def _pause(page: PageConnection, fields: Values) -> None:
    page.frames.stop()
    await page.frames.send()
    page.server.refresh_steps()


async def _check(page: PageConnection, fields: Values) -> None:
    style, number, server = page.style, page.number, page.server
    if style is None:
        raise UsageError("the designer", "has no style open", "open one first")
    frame = await server.run(server.designer.clip.frame, number, page.side)
    data = await server.picture(lambda: encode(render_exactly(style, frame), "png"))
    await page.send_picture(PictureType.EXACT, number, server.designer.opened.revision, data)


async def _start(page: PageConnection, fields: Values) -> None:
    """Send a preview of each style, rendered from the current frame."""
    server = page.server
    frame = await server.run(server.designer.clip.frame, page.number, STYLE_PREVIEW_PX)
    for index, name in enumerate(style_names()):
        try:
            style = await server.run(load_style, name)
            data = await server.picture(lambda style=style: encode(render_exactly(style, frame), "jpeg"))
        except StyleError:  # an invalid style file of the user; the list shows its error
            continue
        await page.send_picture(PictureType.STYLE, index, 0, data)


async def _thumbnails(page: PageConnection, fields: Values) -> None:
    page.server.refresh_steps()


async def _export(page: PageConnection, fields: Values) -> Values:
    return {"file": await asyncio.to_thread(page.server.designer.export, **fields)}


async def _render(page: PageConnection, fields: Values) -> None:
    await page.server.jobs.render(**fields)


async def _steady(page: PageConnection, fields: Values) -> None:
    await page.server.jobs.steady(page)


async def _cancel(page: PageConnection, fields: Values) -> None:
    page.server.jobs.cancel()


async def _upload(page: PageConnection, id: int, fields: Values) -> None:
    if page.upload is not None:
        raise MessageError("upload: another upload is in progress")
    upload = FileUpload(page, id, **fields)

    async def work() -> None:
        upload.open()
        page.upload = upload

    await page.answer(id, work)


ACTIONS: Mapping[str, Action] = {
    **{kind: _edit(kind) for kind in EDIT_FIELDS},
    **{kind: _document(kind) for kind in ("undo", "redo", "jump", "snapshot", "restore")},
    **{kind: _designer(kind) for kind in ("new", "open", "open_text", "save", "save_as")},
    "draft": _designer("open_draft"),
    "command": _query_action(_command),
    "watch": _query_action(_watch),
    "frame": _query_action(_frame),
    "play": _query_action(_play),
    "pause": _query_action(_pause),
    "thumbnails": _query_action(_thumbnails),
    "start": _query_action(_start, in_background=True),
    "check": _query_action(_check, in_background=True),
    "steady": _query_action(_steady, in_background=True),
    "export": _query_action(_export, in_background=True),
    "render": _query_action(_render, in_background=True),
    "cancel": _query_action(_cancel),
    "upload": _upload,
}
"""Actions by message."""
