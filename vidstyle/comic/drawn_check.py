"""A check of key frames as they will be drawn, before the pages are laid out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.empty_margins import find_content, trim
from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.key_frame_source import Film
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.crop import crop, main_face, map_to_page
from vidstyle.comic.output.panel_renderer import PanelRenderer, cut_out
from vidstyle.comic.output.readability import measure_readability
from vidstyle.comic.panel_styles import PanelStyles
from vidstyle.core.closing import Closing
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.faces import FaceFinder

_DRAFT_DPI = 102.0
_DRAFT_WIDTH_PX, _DRAFT_ASPECT_RANGE = 400, (0.8, 2.0)
"""Width of a draft, 10 cm on paper, and the range of its aspect."""
_MIN_MAIN_FACE_RATIO = 0.2
"""Height of a face, relative to the picture's, from which it is what the panel shows."""


class DrawnCheck(Closing):
    """Draws key frames as drafts and measures how well they can be read; a context manager."""

    def __init__(self, film: Film, styles: PanelStyles, device: str, faces: FaceFinder) -> None:
        self._film, self._styles, self._faces = film, styles, faces
        self._renderer = PanelRenderer((), _DRAFT_DPI, device, announce=False, is_draft=True)
        self._known, self._contents = dict[float, float](), dict[float, Box]()

    def close(self) -> None:
        self._renderer.close()

    def readability(self, candidates: Sequence[Candidate]) -> list[float]:
        """Return how well each candidate can be read once it is drawn, 0..1, see `measure_readability`."""
        new = [each for each in candidates if each.time not in self._known]
        frames = self._film.frames_at([each.time for each in new], keep=True)
        for each, frame in zip(new, frames, strict=True):
            self._known[each.time] = self._measure(each, frame)
        return [self._known[each.time] for each in candidates]

    def trim(self, key_frames: Sequence[KeyFrame]) -> list[KeyFrame]:
        """Return the key frames without empty parts above and below what they show."""
        return [trim(each, self._contents[each.time]) for each in key_frames]

    def _measure(self, candidate: Candidate, frame: np.ndarray) -> float:
        height, width = candidate.shape
        low, high = _DRAFT_ASPECT_RANGE
        aspect = min(high, max(low, width / height))
        window, picture = crop(candidate, aspect), candidate.picture(frame)
        self._contents[candidate.time] = find_content(picture)
        place = Rectangle(0, 0, _DRAFT_WIDTH_PX, round(_DRAFT_WIDTH_PX / aspect))
        style = self._styles.of([candidate])[0]
        drawn = self._renderer.draw(style, picture, window, place)
        source = cut_out(picture, window, place.width, place.height)
        face = main_face(candidate)
        if face is not None and face.height < _MIN_MAIN_FACE_RATIO * height:
            face = None
        shown = None if face is None else map_to_page(face, window, place)
        return measure_readability(source, drawn, shown, self._faces.score)
