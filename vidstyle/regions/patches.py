"""Patches: parts of a frame around its faces, side by side in one picture."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import NamedTuple

import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.masks import mask_box
from vidstyle.regions.rasters import NO_RASTER, PageRaster

MIN_MARGIN_RATIO, REST_MARGIN_RATIO, MARGIN_RATIO = 0.15, 0.25, 0.4
"""Widths of the margin around a mask, relative to the face's height: the least, as far as most filters read;
the one from which a window is replaced, while its face is still within it; and the one at first."""
MIN_MARGIN_PX = 8
MAX_SIZE_RATIO = 2.0
"""Factor by which a window may be larger than a new one before it is replaced."""
MAX_ROW_WIDTH_RATIO = 1.5
"""Maximum width of a row of patches, relative to the side of a square with the area of all."""
CHANGE_SECONDS = 0.4
"""Time in which the patches of new windows replace earlier ones."""


class Patch(NamedTuple):
    """A part of a frame.

    Attributes:
        window: its box in the frame.
        place: its box in the picture of all patches.
        face: the face in it; None if it has left.
        weight: 0..1, below 1 while patches of new windows replace earlier ones.
        cover: weight of a newer patch of the same face, which is laid over this one.
    """

    window: Rectangle
    place: Rectangle
    face: Face | None = None
    weight: float = 1.0
    cover: float = 0.0


@dataclass(frozen=True)
class PatchSet:
    """Patches that are restyled as one picture.

    Attributes:
        number: grows with each new choice of windows.
        patches: in the order in which they are laid over the frame.
        is_new: whether this is its first picture.
        least: height of the smallest face when the windows were chosen.
    """

    number: int
    patches: tuple[Patch, ...]
    is_new: bool
    least: float

    @property
    def visible(self) -> list[Patch]:
        """The patches with a face."""
        return [patch for patch in self.patches if patch.face]


@dataclass(frozen=True)
class _Windows:
    """A choice of windows, by track, its time, and the height of the smallest face at that time."""

    number: int
    windows: dict[int, Rectangle]
    places: dict[int, Rectangle]
    time: float
    least: float

    def hold(self, faces: Iterable[Face], margin: float, page: Rectangle) -> bool:
        """Whether there is a window for each of the faces, with at least this margin within the page."""
        return all(
            face.track in self.windows
            and self.windows[face.track].contains(_needed(face.box, margin).intersection(page))
            for face in faces
        )


class PatchPlanner:
    """Selects a window for each face, and its place in the picture of all patches.

    Windows rest, so that the picture of all patches is a film: marks lie still on the page, and what a
    renderer remembers stays valid. If faces enter, leave or move towards the edge of their windows, all
    windows are chosen again, and the new patches replace the others within `CHANGE_SECONDS`.
    """

    def __init__(self) -> None:
        self._numbers = count()
        self._now: _Windows | None = None
        self._before: _Windows | None = None

    def plan(
        self,
        faces: Sequence[Face],
        shape: tuple[int, int],
        step: tuple[int, int],
        time: float | None,
        raster: PageRaster = NO_RASTER,
    ) -> list[PatchSet]:
        """Return the patches for the faces of the next frame; two sets while one replaces the other.

        Args:
            faces: the faces.
            shape: height and width of the frame.
            step: pixels, across and down, of whose multiples windows begin; see `Encoding.subsampling`.
            time: in seconds; None for a picture that stands alone.
            raster: the rasters that patches continue.
        """
        page, before = Box(0, 0, shape[1], shape[0]), self._now
        if not faces or time is None:
            self._now = self._before = None
        elif self._now is not None and not self._is_suitable(faces, page, time):
            self._now, self._before = None, self._now
        if not faces:
            return []
        if self._now is None:
            self._now = self._choose(faces, shape, step, time, raster)
        elapsed = (time or 0.0) - self._now.time
        if not 0 <= elapsed < CHANGE_SECONDS:
            self._before = None
        weight = elapsed / CHANGE_SECONDS if self._before else 1.0
        sets = [] if self._before is None else [_leaving(self._before, faces, weight, page)]
        sets = [each for each in sets if each.visible]
        faded = {patch.face.track for each in sets for patch in each.visible if patch.face}
        patches = (
            Patch(window, self._now.places[track], face, weight if track in faded else 1.0)
            for track, window, face in _matched(self._now, faces)
        )
        return [*sets, PatchSet(self._now.number, tuple(patches), self._now is not before, self._now.least)]

    def _is_suitable(self, faces: Sequence[Face], page: Rectangle, time: float) -> bool:
        """Whether the windows can stay; while they replace others, they stay as long as faces are inside."""
        assert self._now is not None
        if self._before is not None and time - self._now.time < CHANGE_SECONDS:
            return self._now.hold(faces, MIN_MARGIN_RATIO, page)
        is_same = self._now.windows.keys() == {face.track for face in faces}
        large = any(
            self._now.windows[face.track].area > MAX_SIZE_RATIO * _needed(face.box, MARGIN_RATIO).area
            for face in faces
            if face.track in self._now.windows
        )
        return is_same and not large and self._now.hold(faces, REST_MARGIN_RATIO, page)

    def _choose(
        self,
        faces: Sequence[Face],
        shape: tuple[int, int],
        step: tuple[int, int],
        time: float | None,
        raster: PageRaster,
    ) -> _Windows:
        windows = {face.track: _window(face.box, shape, step) for face in faces}
        places = dict(zip(windows, _packed([*windows.values()], step, raster), strict=True))
        number, least = 0 if time is None else next(self._numbers), min(face.box.height for face in faces)
        return _Windows(number, windows, places, time or 0.0, least)


def _leaving(windows: _Windows, faces: Sequence[Face], cover: float, page: Rectangle) -> PatchSet:
    """Return the patches that are replaced, without the faces that have left their windows."""
    patches = (
        Patch(window, windows.places[track], face if face and windows.hold([face], 0, page) else None,
              cover=cover)
        for track, window, face in _matched(windows, faces)
    )  # fmt: skip
    return PatchSet(windows.number, tuple(patches), False, windows.least)


def _matched(windows: _Windows, faces: Sequence[Face]) -> Iterator[tuple[int, Rectangle, Face | None]]:
    """Yield track and window of each window, and the face in it."""
    found = {face.track: face for face in faces}
    for track, window in windows.windows.items():
        yield track, window, found.get(track)


def patches_shape(patches: Sequence[Patch]) -> tuple[int, int]:
    """Return height and width of the picture of all patches."""
    return max(each.place.bottom for each in patches), max(each.place.right for each in patches)


def cut_patches(picture: Picture, patches: Sequence[Patch]) -> Picture:
    """Return the picture of all patches, without alpha; the rest of it is gray, and outside of masks."""
    height, width = patches_shape(patches)
    (black, white), (neutral, _) = picture.encoding.luma_levels, picture.encoding.chroma_levels

    def cut(plane: np.ndarray, kind: str) -> np.ndarray:
        step = picture.encoding.subsampling if kind == "chroma" else (1, 1)
        rows, columns = -(-height // step[1]), -(-width // step[0])
        gray = {"chroma": neutral, "mask": 0}.get(kind, (black + white) / 2)
        whole = np.full((rows, columns, *plane.shape[2:]), gray, plane.dtype)
        for patch in patches:
            whole[plane_area(patch.place, step)] = plane[plane_area(patch.window, step)]
        return whole

    opaque = replace(picture, alpha=None)
    return opaque.map_planes(cut)


def plane_area(box: Rectangle, step: tuple[int, int]) -> tuple[slice, slice]:
    """Return rows and columns of a box in a plane; `step`: pixels per sample, across and down."""
    across, down = step
    return slice(box.top // down, -(-box.bottom // down)), slice(box.left // across, -(-box.right // across))


def _needed(face: Box[float], margin: float) -> Box[float]:
    """Return the box of a face's mask with a margin around, relative to the face's height."""
    around = max(MIN_MARGIN_PX, margin * face.height) if margin else 0.0
    return mask_box(face).padded(around, around, around)


def _window(face: Box[float], shape: tuple[int, int], step: tuple[int, int]) -> Rectangle:
    """Return a new window for a face in the middle."""
    needed = _needed(face, MARGIN_RATIO)
    left, right = _span(needed.center[0], math.ceil(needed.width), shape[1], step[0])
    top, bottom = _span(needed.center[1], math.ceil(needed.height), shape[0], step[1])
    return Box(left, top, right, bottom)


def _span(middle: float, size: int, whole: int, step: int) -> tuple[int, int]:
    """Return first and last column or row of a window within `whole`, at multiples of `step`."""
    size = min(whole, -(-size // step) * step)
    first = min(max(0, round((middle - size / 2) / step)), (whole - size) // step) * step
    return first, first + size


def _packed(windows: Sequence[Rectangle], step: tuple[int, int], raster: PageRaster) -> list[Rectangle]:
    """Return positions for windows in rows of about equal width, the first at the top left."""
    widest = max(max(each.width for each in windows), math.sqrt(sum(each.area for each in windows)))
    places, left, top, bottom = list[Rectangle](), 0, 0, 0
    for window in windows:
        if left and left + window.width > widest * MAX_ROW_WIDTH_RATIO:
            left, top = 0, bottom
        right, down = left - window.left, top - window.top
        more_right, more_down = raster.gap(right, down, step)
        places.append(window.moved(right + more_right, down + more_down))
        left = -(-places[-1].right // step[0]) * step[0]
        bottom = max(bottom, -(-places[-1].bottom // step[1]) * step[1])
    return places
