"""What all browsers of the designer share: the open style and clip, and the threads that work on them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from vidstyle.cues.cue_file import read_cue_text
from vidstyle.cues.cue_list import CueList
from vidstyle.design.designer import CUE_FILE, Designer
from vidstyle.design.document.solo import solo
from vidstyle.design.restyling import Restyler, StepPictures
from vidstyle.gallery.cue_sheet import SheetScene, sheet_data
from vidstyle.pipeline.scenes import find_scenes
from vidstyle.preview.clip import Clip
from vidstyle.preview.outputs import file_of
from vidstyle.preview.representative import glance_jpeg
from vidstyle.style import Style


class DesignSession:
    """The designer and the threads that work for its browsers. All coroutines run in the server's event loop.

    Attributes:
        designer: the open style and clip.
        restyler: renders previews.
        steps: renders thumbnails of steps.
        glance: the frame that represents the clip, see `glance_jpeg`.
    """

    glance: Future[bytes]

    def __init__(self, designer: Designer, device: str) -> None:
        """`device`: renders for browsers that cannot, see `open_renderer`."""
        self.designer = designer
        self.restyler, self.steps = Restyler(device), StepPictures()
        self._work = ThreadPoolExecutor(1, "vidstyle design")
        self._pictures = ThreadPoolExecutor(1, "vidstyle design pictures")
        self.look_at(designer.clip)

    def look_at(self, clip: Clip) -> None:
        """Find the frame that represents a clip, before others are requested, which may compile kernels."""
        self.glance = self._work.submit(glance_jpeg, clip)

    async def run(self, function: Callable[..., Any], *values: Any) -> Any:
        """Call a function that uses the document or the clip, one at a time."""
        return await asyncio.get_running_loop().run_in_executor(self._work, function, *values)

    async def picture(self, function: Callable[..., Any], *values: Any) -> Any:
        """Call a function that renders pictures, one at a time."""
        return await asyncio.get_running_loop().run_in_executor(self._pictures, function, *values)

    @property
    def revision(self) -> int:
        """The revision of the document; 0 if no style is open."""
        document = self.designer.document
        return document.revision if document else 0

    def cue_list(self, text: str) -> CueList:
        """Return the cues of a text; a cue in the open style has its unsaved changes.

        Raises:
            InputError: the text has mistakes.
        """
        document = self.designer.document
        opened = [] if document is None or document.mistakes else [document.style]
        return read_cue_text(text, self._cue_file, opened)

    def scene_sheet(self) -> dict[str, Any]:
        """Find the scenes of the clip; return what the page shows of them.

        Raises:
            UsageError: the clip is a camera.
            InputError: the film cannot be read.
        """
        scenes, rate = find_scenes(file_of(self.designer.clip))
        shown = [SheetScene(each.start, each.end, each.still) for each in scenes]
        document = self.designer.document
        return sheet_data(self._cue_file, shown, rate, [], [document.style] if document else [])

    @property
    def _cue_file(self) -> Path:
        """Style files in cues are relative to it."""
        return self.designer.folder / CUE_FILE

    def shown_style(self, step: int | None) -> Style | None:
        """Return the open style, reduced to the soloed step if any; None if no style is open."""
        document = self.designer.document
        if document is None:
            return None
        places = {each.number: (layer, place) for layer, place, each in document.content.steps}
        if step in places and not document.mistakes:
            return solo(document.style, *places[step])
        return document.style

    def close(self) -> None:
        """Wait for both threads, and release the renderers and the clip."""
        self._work.shutdown()
        self._pictures.shutdown()
        self.designer.keep_draft()
        self.restyler.close()
        self.steps.close()
        self.designer.clip.close()
