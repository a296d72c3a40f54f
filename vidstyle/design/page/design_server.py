"""The web server of the designer: one style, shown in one or more browsers."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from aiohttp import web

from vidstyle.block import CATEGORIES, Block
from vidstyle.blocks import all_blocks
from vidstyle.design.designer import Designer
from vidstyle.design.front_door import FrontDoor
from vidstyle.design.page.design_session import DesignSession
from vidstyle.design.page.design_view import DesignView, clip_message
from vidstyle.design.page.frames import PictureType
from vidstyle.design.page.made_documents import DOCUMENT_PATH, MadeDocuments
from vidstyle.design.page.render_queue import RenderQueue
from vidstyle.design.page.steady_preview import SteadyPreview
from vidstyle.design.samples import block_sample, sample_names
from vidstyle.design.style_list import list_styles
from vidstyle.errors import InputError, StyleError, VidstyleError
from vidstyle.export.export_targets import describe_targets
from vidstyle.gallery.search_words import describe_look
from vidstyle.preview.clip import Clip
from vidstyle.preview.encode import decode_picture, encode
from vidstyle.style import load_style
from vidstyle.style.model import KINDS
from vidstyle.web.page_server import PageServer, jpeg_response, named_pictures
from vidstyle.web.rendered_files import RENDERED_PATH, RenderedFiles

STATIC_FOLDER = Path(__file__).parent.with_name("static")
MAX_PAGES = 3
STEP_THUMBNAIL_PX = 120
"""Shorter side of the thumbnails of steps."""
SETTLED_SECONDS = 0.12
"""Time without an edit after which the thumbnails of steps are updated."""


class DesignServer(PageServer[DesignView]):
    """Serves a designer.

    Attributes:
        designer: the open style and clip.
        session: shared by all browsers.
        queue: renders films.
        steady: renders one second with temporal smoothing.
        front: the ways to other pages, or None.
        documents: the documents that were made from the page.
    """

    def __init__(
        self,
        designer: Designer,
        connect: Callable[[DesignServer], DesignView],
        port: int = 0,
        device: str = "auto",
        front: FrontDoor | None = None,
    ) -> None:
        """Start serving.

        Args:
            connect: makes the connection for a new browser.
            port: port to listen on; 0 selects a free one.
            device: renders for browsers that cannot, see `open_renderer`.
            front: the ways to other pages, for the page of `vidstyle open`.

        Raises:
            OutputError: the port is taken or needs privileges.
        """
        self.designer, self.session = designer, DesignSession(designer, device)
        self.front, self.documents = front, MadeDocuments()
        self._settling: asyncio.Task[None] | None = None
        self._samples = named_pictures(sample_names, self._sample)
        handlers = {
            "/glance.jpg": self._glance,
            "/block.jpg": self._send_sample,
            DOCUMENT_PATH: self.documents.serve,
            RENDERED_PATH: RenderedFiles(lambda number: self.queue.finished(number)).serve,
        }
        super().__init__(
            "designer", lambda: connect(self), handlers, STATIC_FOLDER, "index.html",
            most=MAX_PAGES, port=port,
        )  # fmt: skip
        self.queue = RenderQueue(self.session, self.tasks, self.tell)
        self.steady = SteadyPreview(self.session, self.tell)

    def close(self) -> None:
        """Save a draft of unsaved changes, and stop."""
        self.queue.end()
        self.steady.cancel()
        super().close()
        self.session.close()

    def greeting(self) -> Iterator[dict[str, Any]]:
        """Yield the initial messages for a browser, except the state."""
        yield {
            "blocks": [
                {
                    "name": name,
                    "label": block.label,
                    "category": CATEGORIES[block.category],
                    "help": block.help,
                    "explanation": block.explanation,
                }
                for name, block in sorted(all_blocks().items(), key=_place_in_list)
            ]
        }
        yield {"kinds": list(KINDS.values())}
        yield self.styles
        yield {"targets": describe_targets()}
        yield {"clip": clip_message(self.designer.clip)}
        yield self.queue.message
        if self.front is not None:
            yield {"front": self.front.describe()}

    @property
    def styles(self) -> dict[str, Any]:
        """The list of styles, for the page."""
        listed = list_styles(self.designer.folder)
        return {
            "styles": [
                describe_look(name, partial(load_style, source)) | {"has_name": name == source}
                for name, source in listed.items()
            ]
        }

    async def saved(self) -> None:
        """Send the list of styles, which may have a further one, to all browsers."""
        styles = await self.session.run(lambda: self.styles)
        for page in list(self.browsers):
            await page.tell(styles)

    async def changed(self) -> None:
        """Send the changed document and its pictures to all browsers."""
        state = await self.session.run(lambda: self.designer.state)
        for page in list(self.browsers):
            await page.show_state(state)
        self.refresh_steps()

    async def offer_drafts(self) -> None:
        """Offer the drafts to all browsers."""
        drafts = await self.session.run(self.designer.drafts.describe)
        for page in list(self.browsers):
            await page.tell(drafts)

    async def change_clip(self, clip: Clip) -> None:
        """Show another clip."""
        old, self.designer.clip = self.designer.clip, clip
        self.session.look_at(clip)
        self._samples = named_pictures(sample_names, self._sample)
        for page in list(self.browsers):
            await page.show_clip(clip)
        await self.queue.release(old)
        self.refresh_steps()

    def refresh_steps(self) -> None:
        """Update the thumbnails of steps and save a draft, once edits pause."""
        if self._settling is not None:
            self._settling.cancel()
        self._settling = self.tasks.begin(self._send_steps())

    async def _send_steps(self) -> None:
        await asyncio.sleep(SETTLED_SECONDS)
        document = self.designer.document
        if document is None or not self.browsers:
            return
        number = self.browsers[
            0
        ].frames.shown.number  # the last browser may disconnect during the calls below
        await self.session.run(self.designer.keep_draft)
        revision, style, content = document.revision, document.style, document.content
        if document.mistakes:
            return
        clip, steps = self.designer.clip, self.session.steps
        try:
            made = await self.session.picture(lambda: steps.of(style, clip.frame(number, STEP_THUMBNAIL_PX)))
        except (StyleError, InputError):  # reported by the full-size preview
            return
        for (layer, place), picture in made.items():
            data = await self.session.picture(encode, picture, "jpeg")
            for page in list(self.browsers):
                await page.send_picture(PictureType.STEP, content.layers[layer][place].number, revision, data)

    async def _glance(self, request: web.Request) -> web.StreamResponse:
        """Send the frame that represents the clip, in approximate colours; no kernel is compiled for it."""
        try:
            return jpeg_response(await asyncio.wrap_future(self.session.glance))
        except VidstyleError as error:  # reported when the exact frame is requested
            raise web.HTTPNotFound from error

    async def _send_sample(self, request: web.Request) -> web.StreamResponse:
        return await self._samples(request)

    async def _sample(self, name: str) -> bytes:
        """Return the thumbnail of a block, on the frame that represents the clip."""
        try:
            picture = decode_picture(await asyncio.wrap_future(self.session.glance))
        except VidstyleError:  # reported when the exact frame is requested
            picture = None
        data: bytes = await self.session.picture(block_sample, name, picture)
        return data


def _place_in_list(named: tuple[str, Block]) -> tuple[int, str]:
    """Return the sort key of a block by category and label."""
    _, block = named
    return list(CATEGORIES).index(block.category), block.label
