"""Pictures rendered by the server: previews of frames, thumbnails of steps, exact results."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from fractions import Fraction
from time import perf_counter

import numpy as np

from vidstyle.core.machine.cores import available_cores
from vidstyle.core.picture import Picture
from vidstyle.cpu.step_pictures import step_pictures
from vidstyle.cues.cue_list import Moment
from vidstyle.cues.transitions import mixed_picture
from vidstyle.design.look_tiles import LookTiles
from vidstyle.design.working_size import WorkingSize
from vidstyle.preview.clip import Clip
from vidstyle.regions.frame_masks import FrameMasks
from vidstyle.regions.mask_renderer import MaskRenderer
from vidstyle.regions.still_faces import NO_FACES, KnownFaces, StillFaces
from vidstyle.renderer import open_renderer, restyle_array
from vidstyle.style import Style
from vidstyle.style.nodes import StepKey


class Restyler:
    """Renders previews. All methods must be called from the same thread.

    Attributes:
        size: the size of previews during edits.
    """

    def __init__(self, device: str) -> None:
        """`device`: see `open_renderer`."""
        self._device = device
        self._backend: MaskRenderer | None = None
        self._faces = StillFaces()
        self._tiles: LookTiles | None = None
        self.size = WorkingSize()

    def render_preview(self, style: Style, clip: Clip, number: int, side: int) -> tuple[np.ndarray, bool]:
        """Render a frame soon, to follow a slider: of at most `side`, with marks in proportion.

        Returns:
            The picture, H x W x 3 uint8, and whether `render_large` would show more: it is smaller than
            `side`, or its faces are not known yet, as they take longer to find than most styles.
        """
        has_faces = self._faces.show((clip, number)) or clip.live or not style.focus
        picture = self._render(style, clip, number, self._draft_side(style, clip, side))
        return picture, min(picture.shape[:2]) < side or not has_faces

    def render_playing(self, style: Style, clip: Clip, number: int, side: int) -> tuple[np.ndarray, bool]:
        """Render a frame fast enough to play, as `render_preview` does; marks may be coarser."""
        self._faces.show((clip, number))
        picture = self._render(style, clip, number, self._fast_side(clip, side))
        return picture, min(picture.shape[:2]) < side

    def render_large(self, style: Style, clip: Clip, number: int, side: int) -> tuple[np.ndarray, bool]:
        """Render a frame of `side`, however long it takes; H x W x 3 uint8, and False."""
        self._show_faces(clip, number)
        return self._render(style, clip, number, side), False

    def render_moment(
        self, moment: Moment, clip: Clip, number: int, side: int, large: bool = False
    ) -> tuple[np.ndarray, bool]:
        """Render a frame of a film with cues; during a transition in both of its styles.

        Args:
            large: as `render_large` does, else as `render_preview`.

        Returns:
            The picture, H x W x 3 uint8, and whether it is smaller than `side`.
        """
        self._show_faces(clip, number)
        drawn = side if large else self._fast_side(clip, side)
        return self._render_moment(moment, clip, number, drawn), drawn < side

    def _draft_side(self, style: Style, clip: Clip, side: int) -> int:
        """Return the size of a draft: in pictures smaller than the style's height, marks would be coarser."""
        return self._fast_side(clip, side, side if style.height is None else math.ceil(style.height))

    def _fast_side(self, clip: Clip, side: int, least: int = 0) -> int:
        return self.size.side(side, max(clip.size) / min(clip.size), least)

    def _render_moment(self, moment: Moment, clip: Clip, number: int, side: int) -> np.ndarray:
        active = self._render(moment.active.style, clip, number, side)
        if moment.ending is None:
            return active
        ending = self._render(moment.ending.style, clip, number, side)
        color = mixed_picture(Picture.from_array(ending), Picture.from_array(active), moment).color
        assert color is not None
        return color

    def render_exactly(self, style: Style, clip: Clip, number: int, side: int) -> np.ndarray:
        """Render a frame, H x W x 3 uint8, on the CPU, whose result is the reference."""
        self._show_faces(clip, number)
        style = replace(style, steady=0.0)
        with closing(open_renderer(style, "cpu", announce=False, faces=self._faces)) as renderer:
            return restyle_array(renderer, clip.frame(number, side), seen_side=min(clip.size))

    def tiles(self, clip: Clip, number: int) -> LookTiles:
        """Return what renders the tiles of the start screen from a frame."""
        if clip.live:
            return LookTiles(clip, number, NO_FACES)
        if self._tiles is None or self._tiles.clip is not clip or self._tiles.number != number:
            self._tiles = LookTiles(clip, number, self._find_faces(clip, number))
        return self._tiles

    def render_faces(self, style: Style, clip: Clip, number: int, side: int) -> np.ndarray | None:
        """Render only the faces of a frame, for pages that render the rest; see `FocusRenderer.overlay`.

        Returns:
            H x W x 4 uint8; None without a face.
        """
        self._show_faces(clip, number)
        picture = Picture.from_array(np.ascontiguousarray(clip.frame(number, side)))
        return self._renderer(style).overlay(picture, min(clip.size))

    def _show_faces(self, clip: Clip, number: int) -> None:
        if not clip.live:
            self._find_faces(clip, number)
        self._faces.show((clip, number))

    def _find_faces(self, clip: Clip, number: int) -> KnownFaces:
        return self._faces.find((clip, number), lambda: np.ascontiguousarray(clip.frame(number)))

    def _render(self, style: Style, clip: Clip, number: int, side: int) -> np.ndarray:
        frame = clip.frame(number, side)
        if style.is_plain:
            return frame
        renderer = self._renderer(style)
        began = perf_counter()
        color = restyle_array(renderer, frame, seen_side=min(clip.size))
        self.size.record(frame.shape[0] * frame.shape[1], perf_counter() - began)
        return color

    def _renderer(self, style: Style) -> MaskRenderer:
        """Return the renderer of previews with this style."""
        style = replace(style, steady=0.0)
        if self._backend is None:
            renderer = open_renderer(style, self._device, announce=False, faces=self._faces)
            assert isinstance(renderer, MaskRenderer)
            self._backend = renderer
        self._backend.change_style(style)
        return self._backend

    def close(self) -> None:
        """Release the device."""
        if self._backend is not None:
            self._backend.close()


class StepPictures:
    """Renders thumbnails of the output of each step."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-steps")

    def of(self, style: Style, frame: np.ndarray) -> dict[StepKey, np.ndarray]:
        """See `step_pictures`."""
        with FrameMasks(style) as masks:
            picture = Picture.from_array(frame)
            return step_pictures(style, replace(picture, masks=masks.of(picture, None)), self._pool)

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown()


def render_second(
    style: Style, clip: Clip, first: int, side: int, stopped: Callable[[], bool]
) -> Iterator[tuple[int, int, np.ndarray]]:
    """Render one second of the clip with temporal smoothing; yield frame number, frame count and picture."""
    count = min(max(1, round(clip.fps)), clip.count - first if not clip.live else round(clip.fps))
    with closing(open_renderer(style, "cpu", announce=False)) as renderer:
        for number in range(count):
            if stopped():
                return
            time = Fraction(first + number) / Fraction(clip.fps)
            frame = clip.frame(first + number, side)
            yield first + number, count, restyle_array(renderer, frame, float(time), min(clip.size))
