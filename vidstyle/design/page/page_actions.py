"""What each message of the page does."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from vidstyle.design.page.message_fields import EDIT_FIELDS
from vidstyle.design.page.uploads import FileUpload
from vidstyle.design.restyling import exact
from vidstyle.errors import StyleError, UsageError
from vidstyle.preview.encode import encode
from vidstyle.style import load_style, style_names
from vidstyle.web.messages import MessageError

if TYPE_CHECKING:
    from vidstyle.design.page.page_connection import PageConnection

Values = dict[str, Any]
Action = Callable[["PageConnection", int, Values], Awaitable[None]]
STYLE_PREVIEW_PX = 160
"""Shorter side of the pictures on the start screen."""


def _changing(function: Callable[[PageConnection, Values], Values | None]) -> Action:
    """An action that changes the document: all pages are told before it is answered."""

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


def _asking(
    work: Callable[[PageConnection, Values], Awaitable[Values | None]], beside: bool = False
) -> Action:
    """An action that changes no document; `beside`: further messages do not wait for it."""

    async def action(page: PageConnection, id: int, fields: Values) -> None:
        if not beside:
            await page.answer(id, partial(work, page, fields))
        elif page.is_busy:
            await page.answer(id, _refused)
        else:
            page.begin(page.answer(id, partial(work, page, fields)))

    return action


def _edit(kind: str) -> Action:
    def function(page: PageConnection, fields: Values) -> Values | None:
        # Two pages, or one that was loaded anew, may count gestures alike.
        fields["gesture"] = (id(page), fields["gesture"])
        step = page.server.designer.opened.edit(kind, **fields)
        return None if step is None else {"step": step}

    return _changing(function)


def _document(name: str) -> Action:
    """A method of the document."""

    def function(page: PageConnection, fields: Values) -> None:
        getattr(page.server.designer.opened, name)(**fields)

    return _changing(function)


def _designer(name: str) -> Action:
    """A method of the designer."""

    def function(page: PageConnection, fields: Values) -> None:
        getattr(page.server.designer, name)(**fields)

    return _changing(function)


async def _refused() -> Values:
    raise UsageError("the designer", "is at work", "wait for its answers")


async def _command(page: PageConnection, fields: Values) -> Values:
    return {"text": await page.server.run(page.server.designer.command)}


async def _watch(page: PageConnection, fields: Values) -> None:
    # What a camera shows is asked for by nothing else.
    is_other = fields["side"] != page.side or page.server.designer.clip.live
    page.solo, page.side, page.where = fields["solo"], fields["side"], fields["where"]
    if is_other:
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
    data = await server.picture(lambda: encode(exact(style, frame), "png"))
    await page.send_picture(4, number, server.designer.opened.revision, data)


async def _start(page: PageConnection, fields: Values) -> None:
    """All styles on the user's own picture."""
    server = page.server
    frame = await server.run(server.designer.clip.frame, page.number, STYLE_PREVIEW_PX)
    for index, name in enumerate(style_names()):
        try:
            style = await server.run(load_style, name)
            data = await server.picture(lambda style=style: encode(exact(style, frame), "jpeg"))
        except StyleError:  # a file of the user's own, which the list describes
            continue
        await page.send_picture(5, index, 0, data)


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
        raise MessageError("upload: a file is on its way")
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
    "command": _asking(_command),
    "watch": _asking(_watch),
    "frame": _asking(_frame),
    "play": _asking(_play),
    "pause": _asking(_pause),
    "thumbnails": _asking(_thumbnails),
    "start": _asking(_start, beside=True),
    "check": _asking(_check, beside=True),
    "steady": _asking(_steady, beside=True),
    "export": _asking(_export, beside=True),
    "render": _asking(_render, beside=True),
    "cancel": _asking(_cancel),
    "upload": _upload,
}
"""By the kind of the message."""
