"""The connection to one browser that shows the designer: the messages of its page."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

from vidstyle.block.absent_effects import find_absent_effect
from vidstyle.block.search import find_blocks, find_values, is_named, is_value_name
from vidstyle.blocks import all_blocks
from vidstyle.design.document.document import SNAPSHOT_SLOTS
from vidstyle.design.document.edit_values import EditResult
from vidstyle.design.document.edits import EDITS
from vidstyle.design.document.step_text import text_of_step
from vidstyle.design.drafts import MAX_DRAFTS
from vidstyle.design.page.design_server import DesignServer
from vidstyle.design.page.design_view import DesignView
from vidstyle.design.page.frames import PictureType
from vidstyle.design.style_list import list_styles
from vidstyle.errors import StyleError, UsageError
from vidstyle.gallery.thumbnail import shipped_thumbnail
from vidstyle.preview.clip import DemoClip
from vidstyle.preview.encode import encode
from vidstyle.preview.outputs import ExportKind
from vidstyle.preview.uploads import FileUpload, UploadReceiver
from vidstyle.style import Style, load_style, table_from_style
from vidstyle.style.knobs import knobs_of
from vidstyle.style.model import FIELDS
from vidstyle.web.messages import (
    CHECKS,
    Answer,
    Message,
    TextOrEmpty,
    fields_of,
    integer_between,
    message,
    number_between,
    one_of,
    text_between,
)

UploadSize = Annotated[int, integer_between(1, 2 << 30)]
"""In bytes."""
PreviewSide = Annotated[int, integer_between(64, 2160)]
"""The shorter side of the preview in pixels."""
TileWidth = Annotated[int, integer_between(1, 1 << 15)]
"""The width on the screen of tiles of the start screen, in pixels; no tile is wider than it is rendered."""
DraftPlace = Annotated[int, integer_between(0, MAX_DRAFTS)]
PlaybackRate = Annotated[float, number_between(0.1, 240)]
SnapshotSlot = Annotated[str, one_of(SNAPSHOT_SLOTS)]
CueText = Annotated[str, text_between(0, 50_000)]
"""The text of a cue file; empty: the open style."""


def _edit_message(name: str, edit: Callable[..., EditResult]) -> Message:
    """Return the message that makes an edit; its fields are the arguments of the edit after `new`."""

    async def handle(page: DesignConnection, gesture: int, **fields: Any) -> Answer:
        # Two browsers, or a reloaded page, may use the same gesture numbers.
        step = await page.change(lambda: page.designer.opened.edit(name, (id(page), gesture), **fields))
        return None if step is None else {"step": step}

    return Message(handle, {**fields_of(edit, 2), "gesture": CHECKS[int]})


def _numbered(folder: Path, own: bool) -> list[tuple[int, Style]]:
    """Return the valid styles, or only the styles of the folder, with their positions in the list."""
    styles: list[tuple[int, Style]] = []
    for index, (name, source) in enumerate(list_styles(folder).items()):
        if own and name == source:
            continue
        with suppress(StyleError):  # a style file of the user; the list shows its error
            styles.append((index, load_style(source)))
    return styles


class DesignConnection(DesignView):
    """Serves one WebSocket: the edits of a style, and the messages declared here."""

    messages = {name: _edit_message(name, edit) for name, edit in EDITS.items()}

    def __init__(self, server: DesignServer) -> None:
        super().__init__(server.session, fail=server.fail)
        self.server, self.designer = server, server.designer
        self._uploads = UploadReceiver()

    async def greet(self) -> None:
        """Send blocks, styles, export targets, the clip, the state and the drafts of earlier runs."""
        for each in await self.session.run(lambda: list(self.server.greeting())):
            await self.tell(each)
        await self.show_state(await self.session.run(lambda: self.designer.state))
        await self.tell(await self.session.run(self.designer.drafts.describe))
        self.server.refresh_steps()

    def leave(self) -> None:
        """Stop playing and drop the upload."""
        self.frames.stop()
        self._uploads.drop()

    async def change(self, work: Callable[..., Any], *values: Any) -> Any:
        """Call a function that may change the document; all browsers get the change before the answer."""
        before = (self.designer.document, self.session.revision)
        answer = await self.session.run(work, *values)
        if (self.designer.document, self.session.revision) != before:
            await self.server.changed()
        return answer

    async def _replace(self, work: Callable[..., Any], *values: Any) -> None:
        """Call a function that opens another document; unsaved changes are offered as a draft."""
        await self.change(work, *values)
        await self.server.offer_drafts()

    # The document and its file

    @message
    async def undo(self) -> None:
        await self.change(lambda: self.designer.opened.undo())

    @message
    async def redo(self) -> None:
        await self.change(lambda: self.designer.opened.redo())

    @message
    async def jump(self, entry: int) -> None:
        await self.change(lambda: self.designer.opened.jump(entry))

    @message
    async def snapshot(self, slot: SnapshotSlot) -> None:
        await self.change(lambda: self.designer.opened.snapshot(slot))

    @message
    async def restore(self, slot: SnapshotSlot) -> None:
        await self.change(lambda: self.designer.opened.restore(slot))

    @message
    async def new(self) -> None:
        await self._replace(self.designer.new)

    @message
    async def open(self, style: str) -> None:
        await self._replace(self.designer.open, style)

    @message
    async def draft(self, accept: bool, place: DraftPlace) -> None:
        await self._replace(self.designer.open_draft, accept, place)

    @message
    async def save(self) -> Answer:
        return {"file": await self.change(self.designer.save)}

    @message
    async def save_as(self, name: str, overwrite: bool) -> Answer:
        file = await self.change(self.designer.save_as, name, overwrite)
        await self.server.saved()
        return {"file": file}

    @message
    async def copied(self, step: int, whole: bool) -> Answer:
        """Answer with a step, or all of its layer, as text."""
        return {"text": text_of_step(self.designer.opened.content, step, whole)}

    @message
    async def find(self, text: TextOrEmpty) -> Answer:
        """Answer with the blocks, and the paths of fields and knobs, that a text describes, best first.

        `values_first` is whether the text is the name of the first value rather than of a block.

        Of an effect that no block has, the answer names what comes nearest, with a note.
        """
        style, absent = self.designer.opened.style, find_absent_effect(text)
        if absent is not None:
            note = f"No step is exactly “{text}”. {absent.advice} Closest:"
            return {"blocks": absent.nearest, "values": absent.values, "values_first": False, "note": note}
        values = FIELDS | knobs_of(style, table_from_style(style))
        found, found_values = find_blocks(text, all_blocks()), find_values(text, values)
        best = all_blocks()[found[0]] if found else None
        values_first = bool(found_values) and is_value_name(values[found_values[0]], text, best)
        note = "" if is_named(text, all_blocks(), values) else f"No step is exactly “{text}”. Closest:"
        return {
            "blocks": found,
            "values": found_values,
            "values_first": values_first,
            "note": note if found else "",
        }

    @message
    async def command(self, name: TextOrEmpty, frames: int | None) -> Answer:
        has_cues = self.frames.shown.cues is not None
        return {"text": await self.session.run(self.designer.command, name, frames, has_cues)}

    @message(in_background=True)
    async def export(self, kind: ExportKind, name: str, overwrite: bool) -> Answer:
        return {"file": await asyncio.to_thread(self.designer.export, kind, name, overwrite)}

    # Pictures

    @message
    async def watch(self, solo: int | None, side: PreviewSide, where: Literal["page", "server"]) -> None:
        shown = self.frames.shown
        # No other message requests the frames of a camera.
        needs_frame = side != shown.side or self.designer.clip.live
        shown.solo, shown.side, shown.where = solo, side, where
        if needs_frame:
            await self.frames.send()
        await self.show_style()

    @message
    async def frame(self, number: int) -> None:
        self.frames.stop()
        self.frames.shown.number = min(number, self.designer.clip.count - 1)
        await self.frames.send()
        self.server.refresh_steps()

    @message
    async def play(self, at: int, first: int, last: int, fps: PlaybackRate) -> None:
        end = self.designer.clip.count - 1
        first, last = min(first, end), min(last, end)
        self.frames.play(at if first <= at <= last else first, first, max(first, last), float(fps))

    @message
    async def pause(self) -> None:
        self.frames.stop()
        await self.frames.send()
        self.server.refresh_steps()

    @message(in_background=True)
    async def start(self, width: TileWidth, own: bool) -> None:
        """Send a tile of each style, or only of own styles, rendered from the current frame, in order."""
        number, session, clip = self.frames.shown.number, self.session, self.designer.clip
        order = await session.run(_numbered, self.designer.folder, own)
        if isinstance(clip, DemoClip) and not own:
            await self._send_thumbnails(order)
        tiles = await session.picture(session.restyler.tiles, clip, number)
        for done, (index, style) in enumerate(order):
            if self.designer.clip is not clip:  # another one was opened, and asks for its own previews
                return
            await self.tell({"previews": {"done": done, "total": len(order)}})
            await self.frames.settle()  # an open look comes before the others
            try:
                picture = await session.picture(tiles.render, style, width)
            except StyleError:  # such as one whose mask does not fit this clip
                continue
            if self.designer.clip is clip:
                await self.send_picture(PictureType.STYLE, index, 0, encode(picture, "jpeg"))
        await self.tell({"previews": {"done": len(order), "total": len(order)}})

    async def _send_thumbnails(self, styles: list[tuple[int, Style]]) -> None:
        """Send the shipped thumbnails, which show the example too, until its tiles are rendered."""
        for index, style in styles:
            picture = await asyncio.to_thread(shipped_thumbnail, style)
            if picture is not None and isinstance(self.designer.clip, DemoClip):
                await self.send_picture(PictureType.STYLE, index, 0, encode(picture, "jpeg"))

    @message(in_background=True)
    async def check(self, side: PreviewSide) -> None:
        """Send the exact result for the current frame, of at most `side`."""
        style, shown, session = self.frames.style, self.frames.shown, self.session
        if style is None:
            raise UsageError("the designer", "has no style open", "open one first")
        if shown.cues is not None:
            raise UsageError("the check", "compares the open style", "hide the scenes first")
        number, clip = shown.number, self.designer.clip
        picture = await session.picture(session.restyler.render_exactly, style, clip, number, side)
        await self.send_picture(PictureType.EXACT, number, session.revision, encode(picture, "png"))

    @message(in_background=True)
    async def opened(self, number: int, side: PreviewSide) -> None:
        """Send a frame in the style as opened, of at most `side`."""
        session, clip = self.session, self.designer.clip
        number = min(number, clip.count - 1)
        style = self.designer.opened.opened_style
        picture = await session.picture(session.restyler.render_exactly, style, clip, number, side)
        await self.send_picture(PictureType.OPENED, number, session.revision, encode(picture, "jpeg"))

    @message(in_background=True)
    async def scenes(self) -> Answer:
        """Answer with the scenes of the film and all styles, for its cues."""
        return {"sheet": await asyncio.to_thread(self.session.scene_sheet)}

    @message
    async def cues(self, text: CueText) -> None:
        await self.show_cues(text)

    # Long jobs and uploads

    @message(in_background=True)
    async def steady(self) -> None:
        await self.server.steady.send(self, self.frames)

    @message(in_background=True)
    async def render(self, name: TextOrEmpty, overwrite: bool, frames: int | None) -> Answer:
        look = self.frames.shown.cues or self.designer.opened.valid_style()
        return {"file": await self.server.queue.render(name, overwrite, frames, look)}

    @message
    async def cancel(self) -> None:
        self.server.queue.cancel()
        self.server.steady.cancel()

    @message
    async def stop(self, job: int) -> None:
        await self.server.queue.stop(job)

    @message
    async def resume(self, job: int) -> None:
        await self.server.queue.resume(job)

    @message
    async def discard(self, job: int) -> None:
        await self.server.queue.remove(job)

    @message
    async def reveal(self, job: int) -> None:
        """Show the file of a job in its folder."""
        path = self.server.queue.job(job).path
        reveal = self.server.front.reveal if self.server.front is not None else None
        if reveal is None:
            raise UsageError(str(path), "cannot be shown from here", "open its folder yourself")
        await asyncio.to_thread(reveal, path)

    @message(in_background=True)
    async def page(self, kind: str) -> Answer:
        """Open another page on the file of the clip, or make a document of it; answer with its address."""
        pages = self.server.front.pages if self.server.front is not None else {}
        if kind not in pages:
            raise UsageError(f"the page {kind}", "cannot be opened from here")
        source = await self.session.run(self.designer.clip.file)
        loop = asyncio.get_running_loop()

        def report(text: str) -> None:
            asyncio.run_coroutine_threadsafe(self.tell({"making": {"kind": kind, "text": text}}), loop)

        address = await asyncio.to_thread(pages[kind], source, report)
        if not address.startswith("http"):
            await self.tell({"notice": f"Saved as {address}."})
            address = self.server.documents.add(Path(address))
        return {"url": address}

    @message
    async def cancel_page(self) -> None:
        """Stop making documents, such as comics."""
        if self.server.front is not None:
            self.server.front.cancel()

    @message
    async def upload(self, id: int, name: str, size: UploadSize) -> None:
        """Announce a file, which follows in binary messages; the last one is answered too."""
        self._uploads.announce(id, name, size)

    async def take_bytes(self, data: bytes) -> None:
        """Take a chunk of the upload; open the file after the last one, and answer the upload."""
        upload = await self._uploads.take(data)
        if upload is not None:
            await self.answer(upload.id, lambda: self._use(upload))

    async def _use(self, upload: FileUpload) -> None:
        opened = await self.session.run(upload.open)
        if isinstance(opened, tuple):
            await self._replace(self.designer.open_text, *opened)
        else:
            await self.server.change_clip(opened)
