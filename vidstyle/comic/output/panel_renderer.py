"""Panel rendering: pictures are restyled at the size at which they are printed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import cycle

import cv2
import numpy as np

from vidstyle.backend import Backend
from vidstyle.comic.analyze.key_frame_source import Film
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.layout import PageLayout
from vidstyle.comic.layout.storyboard import format_timecode
from vidstyle.comic.lettering.fonts import Letters, remove_stress
from vidstyle.comic.output.color_cast import reduce_color_cast
from vidstyle.comic.output.compression_noise import smooth_compression_noise
from vidstyle.comic.output.enlargement import sharpen_enlarged
from vidstyle.comic.output.panel_light import LightChoice
from vidstyle.comic.output.paper_scale import reduction_factor, scale_to_paper
from vidstyle.comic.output.sheet import Label, RenderedPanel, Sheet
from vidstyle.comic.output.write import Frames
from vidstyle.core.closing import Closing
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.renderer import open_renderer, restyle_array
from vidstyle.style import Style

MAX_OVERSAMPLING, MAX_OVERSAMPLED_PIXELS = 2.0, 12e6
"""Enough for enlarged panels; more pixels make drawing slow and files large."""


def oversampling_of(sizes: Iterable[tuple[int, int]]) -> float:
    """Return the oversampling of pages of these widths and heights that are shown one panel at a time.

    >>> oversampling_of([(1800, 1100)]), oversampling_of([(1800, 1100)] * 100)
    (2.0, 1.0)
    """
    pixels = sum(width * height for width, height in sizes)
    return min(MAX_OVERSAMPLING, max(1.0, math.sqrt(MAX_OVERSAMPLED_PIXELS / pixels)))


class PanelRenderer(Closing):
    """Renders panels, using the styles in rotation; a context manager.

    Args:
        styles: of the panels.
        dpi: pixels per inch of the page.
        device: as for `open_renderer`.
        announce: as for `open_renderer`.
        oversampling: pixels of a picture per pixel of the page, for a page that can be enlarged.
        is_draft: whether panels are drawn at the resolution of the page, however low.
    """

    def __init__(
        self,
        styles: Sequence[Style],
        dpi: float,
        device: str,
        announce: bool = True,
        oversampling: float = 1,
        is_draft: bool = False,
    ) -> None:
        self._styles, self._dpi, self._device, self._announce = cycle(styles), dpi, device, announce
        self._oversampling, self._is_draft = oversampling, is_draft
        self._backend: Backend | None = None
        self._scaled: Style | None = None
        self._lights = LightChoice()

    def close(self) -> None:
        if self._backend is not None:
            self._backend.close()

    def panel(self, color: np.ndarray, window: Box, picture: Rectangle) -> np.ndarray:
        """Restyle the part of a frame that a panel shows.

        Args:
            color: the frame, H x W x 3 uint8.
            window: the part, in pixels of the frame.
            picture: rectangle on the page; only its size matters.

        Returns:
            H x W x 3 uint8, of the size of `picture` times the oversampling.
        """
        return self.draw(next(self._styles), color, window, picture)

    def draw(self, style: Style, color: np.ndarray, window: Box, picture: Rectangle) -> np.ndarray:
        """Restyle a part of a frame in any style; otherwise like `panel`."""
        width, height = (round(side * self._oversampling) for side in (picture.width, picture.height))
        if style.is_plain:
            return cut_out(color, window, width, height)
        dpi = self._dpi * self._oversampling
        reduction = 1.0 if self._is_draft else reduction_factor(style, dpi)
        size = round(width * reduction), round(height * reduction)
        source = reduce_color_cast(cut_out(color, window, *size, is_cleaned=True))
        known = dict[bytes, np.ndarray]()

        def restyle(shown: np.ndarray) -> np.ndarray:
            # Lights can be equal, and a draft is as small as the pictures by which its light is chosen.
            key = shown.tobytes()
            if key not in known:
                known[key] = self._restyle(style, shown, dpi * shown.shape[1] / width)
            return known[key]

        light = self._lights.choose(style.name, color, source, restyle)
        drawn = restyle(light(source))
        if reduction == 1:
            return drawn
        return cv2.resize(drawn, (width, height), interpolation=cv2.INTER_AREA)

    def _restyle(self, style: Style, color: np.ndarray, dpi: float) -> np.ndarray:
        """Restyle a picture that has this many pixels per inch of paper."""
        scaled = scale_to_paper(style, color.shape[0], color.shape[1], dpi)
        if self._backend is None:
            self._backend = open_renderer(scaled, self._device, self._announce)
        elif scaled != self._scaled:  # an equal style is still prepared
            self._backend.change_style(scaled)
        self._scaled = scaled
        # Lengths fit the paper: a small panel is no small picture.
        return restyle_array(self._backend, color, seen_side=math.inf)


def cut_out(color: np.ndarray, window: Box, width: int, height: int, is_cleaned: bool = False) -> np.ndarray:
    """Return a part of a picture, H x W x 3 uint8, at another size.

    `is_cleaned`: whether a part that is enlarged is sharpened, and its compression noise removed.
    """
    tall, wide = color.shape[:2]
    # With an extreme aspect of pixels, the window can lie outside: the last row or column is shown.
    left = min(max(0, math.floor(window.left)), wide - 1)
    top = min(max(0, math.floor(window.top)), tall - 1)
    right, bottom = min(wide, math.ceil(window.right)), min(tall, math.ceil(window.bottom))
    part = color[top : max(bottom, top + 1), left : max(right, left + 1)]
    shrinks = width <= part.shape[1] and height <= part.shape[0]
    part = np.ascontiguousarray(part) if shrinks or not is_cleaned else smooth_compression_noise(part)
    method = cv2.INTER_AREA if shrinks else cv2.INTER_CUBIC
    found = cv2.resize(part, (max(1, width), max(1, height)), interpolation=method)
    factor = math.sqrt(found.size / part.size)
    return sharpen_enlarged(found, factor) if is_cleaned and factor > 1 else found


@dataclass(frozen=True)
class PagePlan:
    """A complete comic before it is drawn.

    Attributes:
        key_frames: the key frames shown.
        layout: the panels of each page.
        labels: the labels of each page.
        letters: the font.
        dpi: pixels per inch.
        right_to_left: reading order.
    """

    key_frames: Sequence[KeyFrame]
    layout: PageLayout
    labels: Sequence[list[Label]]
    letters: Letters
    dpi: float
    right_to_left: bool = False


def draw_pages(
    plan: PagePlan,
    film: Film,
    renderer: PanelRenderer,
    frames: Frames | None,
    on_panel: Callable[[int, int], None],
) -> Iterator[Sheet]:
    """Draw pages one at a time, so that only one page and one frame are in memory.

    Args:
        plan: the comic to draw.
        film: source of the frames.
        renderer: draws the panels.
        frames: folder to which the frames are saved as well, or None.
        on_panel: called before each panel with its index and the number of panels.
    """
    panels = plan.layout.panels
    colors = film.frames_at(plan.key_frames[each.key_frame].time for each in panels)
    for page, (width, height) in enumerate(plan.layout.sizes):
        sheet = Sheet(width, height, plan.dpi, plan.letters, labels=plan.labels[page])
        sheet.right_to_left = plan.right_to_left
        for number, each in enumerate(panels):
            if each.page == page:
                on_panel(number, len(panels))
                color, key_frame = next(colors), plan.key_frames[each.key_frame]
                if frames:
                    frames.save(color, key_frame)
                shown = renderer.panel(key_frame.picture(color), each.crop, each.picture)
                said = " / ".join(remove_stress(" ".join(bubble.block.lines)) for bubble in each.bubbles)
                note = ": ".join(filter(None, [format_timecode(key_frame.time), said]))
                sheet.panels.append(
                    RenderedPanel(each.rectangle, each.picture, shown, each.bubbles, note, each.leans)
                )
        yield sheet
