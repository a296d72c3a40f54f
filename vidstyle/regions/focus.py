"""Focus: restyles faces in finer detail and keeps writing, over the rest of the picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import cv2
import numpy as np

from vidstyle.backend import Backend, FrameRequest, PendingPicture, completed_future
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.scene_cuts import KnownCuts
from vidstyle.core.shared_tones import SharedTones
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.feature_drawing import draw_features
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.patch_blending import lay_over, patch_mask
from vidstyle.regions.patch_renderer import OpenRenderer, PatchRenderer
from vidstyle.regions.patches import PatchPlanner, PatchSet, plane_area
from vidstyle.regions.rasters import NO_RASTER, PageRaster, raster_of
from vidstyle.regions.writing.lifting import LiftedWriting
from vidstyle.regions.writing.stroke_drawing import draw_writing
from vidstyle.stabilize.still import flatten_still
from vidstyle.style import Style

FACE_RATIOS = 0.22, 0.32
"""Heights of faces relative to the picture's shorter side. Focus is complete up to the first; from the second
on there is none, as marks are small enough for the face."""


MAX_CELL_RATIO = 6 / 720
"""Largest side of squares in which features are drawn, relative to the picture's shorter side."""


class FaceSource(Protocol):
    """Returns the faces of pictures: `FaceFollower` of films, `StillFaces` of pictures."""

    def follow(self, picture: Picture, time: float | None) -> tuple[Face, ...]:
        """Return the faces of the next picture, the largest first; see `FaceFollower.follow`."""

    def close(self) -> None:
        """End its threads."""


@dataclass(frozen=True)
class FocusedPicture:
    """A picture that is being restyled, its faces in finer detail, and its writing; see `PendingPicture`.

    Attributes:
        writing: is drawn over it, in the ink of the style.
        region: where the style applies, H x W float32, 0..1; None: everywhere.
        raster: the dots and squares of the style.
        features: eyes, noses and mouths, which are drawn over the faces.
    """

    page: PendingPicture
    faces: Sequence[tuple[PendingPicture, PatchSet]]
    features: Sequence[Features]
    writing: LiftedWriting
    style: Style
    region: np.ndarray | None
    raster: PageRaster

    def result(self) -> Picture:
        """The restyled picture; waits for it."""
        page = styled = self.page.result()
        for fine, patches in self.faces:
            page = lay_over(page, styled, fine.result(), patches, self.region, self.raster.cell)
        if self.features:
            page = draw_features(page, self.features, self.style, self.region, self.raster)
        if strokes := self.writing.strokes():
            page = draw_writing(page, strokes, self.style, self.region, self.raster.cell)
        return page

    def covers(self, shape: tuple[int, int]) -> np.ndarray:
        """Return where focus may change a picture of this shape, H x W bool."""
        whole = np.zeros(shape, bool)
        for _, patches in self.faces:
            for patch in patches.visible:
                whole[plane_area(patch.window, (1, 1))] |= patch_mask(patch, self.raster.cell) > 0
        for strokes in self.writing.strokes():
            whole[plane_area(strokes.window, (1, 1))] = True
        return whole


class FocusRenderer(Backend):
    """Restyles pictures, and their faces a second time in finer detail.

    Only the parts of the picture around faces are restyled twice, side by side in one picture. Writing is
    taken off the picture before, and drawn over the result. Without a face and writing, the result is the
    same as without focus.

    Args:
        style: the style; its `focus` and `height` decide about the detail.
        open_backend: opens a renderer for a style and scene cuts; called again at the first face.
        faces: finds the faces of pictures; closed with the renderer.
        cuts: scene cuts of the film; None: they are detected.
        side_ratio: the shorter side of the whole picture relative to the pictures to restyle, where those are
            parts of it: decides how small a face is.

    Attributes:
        device_kind: see `Backend`.
    """

    def __init__(
        self,
        style: Style,
        open_backend: OpenRenderer,
        faces: FaceSource,
        cuts: KnownCuts | None = None,
        side_ratio: float = 1.0,
    ) -> None:
        self._style, self._side_ratio = style, side_ratio
        self._page = open_backend(style, cuts)
        # Two sets of patches, while one replaces the other.
        self._patches = PatchRenderer(open_backend, side_ratio), PatchRenderer(open_backend, side_ratio)
        self._source, self._planner = faces, PatchPlanner()
        self._raster: tuple[object, PageRaster] | None = None
        self.device_kind = self._page.device_kind

    @property
    def frames_in_flight(self) -> int:
        """See `Backend`."""
        return self._page.frames_in_flight

    def memory(self) -> Sequence[np.ndarray]:
        """Return the memory of the rest of the picture; see `Backend.memory`."""
        return self._page.memory()

    def cancel(self) -> None:
        """Give up the pictures in flight; see `Backend.cancel`."""
        for each in (self._page, *self._patches):
            each.cancel()

    def close(self) -> None:
        """Close all renderers, and end the search for faces."""
        for each in (self._source, self._page, *self._patches):
            each.close()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self._style = style
        self._page.change_style(style)

    def restyle(self, request: FrameRequest) -> Picture:
        """Restyle a picture, then its faces; see `Backend.restyle`."""
        return self._start(request, lambda backend, each: completed_future(backend.restyle(each))).result()

    def begin(self, request: FrameRequest) -> PendingPicture:
        """Find the faces of a picture, and start to restyle the picture and the faces."""
        return self._start(request, lambda backend, each: backend.begin(each))

    def _start(
        self, request: FrameRequest, start: Callable[[Backend, FrameRequest], PendingPicture]
    ) -> PendingPicture:
        request, style = flatten_still(request, self._style.steady), self._style
        sets, tones = self._plan(request), SharedTones()
        if not self._is_focused:
            return start(self._page, request)
        writing = LiftedWriting(request.picture, style.focus)
        request = replace(request, edit=writing.picture)
        if request.time is None:
            request = request.edited()
            if not sets and not writing.strokes():
                return start(self._page, request)
        page = start(self._page, replace(request, measured=tones) if sets else request)
        lifted = replace(request.edited(), tones=tones) if sets else request
        faces = list[tuple[PendingPicture, PatchSet]]()
        features = dict[int, Features]()
        for patches in sets:
            backend, fine, found = self._prepare(lifted, patches)
            faces.append((start(backend, fine), patches))
            features |= {each.face.track: each for each in found}
        region, raster = _region(request.picture, style), self._raster_on(request)
        return FocusedPicture(page, faces, list(features.values()), writing, style, region, raster)

    def skip(self, request: FrameRequest) -> None:
        """Follow faces and their tones through a picture that is not restyled."""
        for patches in self._plan(request):
            self._patches_of(patches).cut(request, patches, self._style.focus, self._lift(request))

    def overlay(self, picture: Picture) -> np.ndarray | None:
        """Return what focus changes in a single picture, to be laid over it by other means.

        Returns:
            H x W x 4 uint8, RGB with the changed parts as alpha; None if there are none.
        """
        target = Encoding(full_range=True, subsampling=(1, 1))
        focused = self._start(
            FrameRequest(picture, None, target, rgb=True),
            lambda backend, each: completed_future(backend.restyle(each)),
        )
        if not isinstance(focused, FocusedPicture):
            return None
        color = focused.result().color
        assert color is not None
        return np.dstack([color, 255 * focused.covers(picture.shape).astype(np.uint8)])

    @property
    def _is_focused(self) -> bool:
        return bool(self._style.focus) and self._style.height is not None and not self._style.is_plain

    def _prepare(
        self, request: FrameRequest, patches: PatchSet
    ) -> tuple[Backend, FrameRequest, list[Features]]:
        return self._patches_of(patches).prepare(request, patches, self._style, self._lift(request))

    def _lift(self, request: FrameRequest) -> float:
        """Return how much of features is drawn over the result: nothing in large squares and letters."""
        cell, most = self._raster_on(request).cell, MAX_CELL_RATIO * min(request.picture.shape)
        return 0.0 if cell and max(cell) > most else self._style.focus

    def _patches_of(self, patches: PatchSet) -> PatchRenderer:
        return self._patches[patches.number % len(self._patches)]

    def _plan(self, request: FrameRequest) -> list[PatchSet]:
        """Return the patches for the faces that need finer detail."""
        picture = request.picture
        if not self._is_focused:
            return []
        side = self._side_ratio * min(picture.shape)
        small = [_limited(face, side) for face in self._source.follow(picture, request.time)]
        across, down = map(max, picture.encoding.subsampling, request.encoding.subsampling)
        faces = [face for face in small if face.opacity > 0]
        raster = self._raster_on(request) if faces else NO_RASTER
        return self._planner.plan(faces, picture.shape, (across, down), request.time, raster)

    def _raster_on(self, request: FrameRequest) -> PageRaster:
        """Return the rasters of the style on the page."""
        key = self._style, request.picture.shape, request.encoding, request.rgb
        if self._raster is None or self._raster[0] != key:
            self._raster = key, raster_of(self._style, request)
        return self._raster[1]


def _limited(face: Face, side: float) -> Face:
    """Return the face with less opacity the larger it is in a picture with this shorter side."""
    small, large = FACE_RATIOS
    share = (large - face.box.height / side) / (large - small)
    return replace(face, opacity=face.opacity * min(1.0, max(0.0, share)))


def _region(picture: Picture, style: Style) -> np.ndarray | None:
    """Return where a style applies, by its `only` and `keep`: H x W float32, 0..1; None: everywhere."""
    inside = picture.masks[style.only] if style.only else None
    if style.keep:
        kept = cv2.bitwise_not(picture.masks[style.keep])
        inside = kept if inside is None else cv2.multiply(inside, kept, scale=1 / 255)
    return None if inside is None else inside * np.float32(1 / 255)
