"""Focus: restyles faces in finer detail and keeps writing, over the rest of the picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import cv2
import numpy as np

from vidstyle.backend import Backend, FrameRequest, PendingPicture, completed_future, joined_future
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.scene_cuts import SceneCuts
from vidstyle.core.shared_tones import SharedTones
from vidstyle.picture_edit import PictureEdit
from vidstyle.regions.automatic_detail import FULL_FOCUS, small_picture_detail, with_detail
from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.face_light import DimFaces, light_faces
from vidstyle.regions.features.feature_drawing import draw_features
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.media import Medium
from vidstyle.regions.patch_blending import lay_over, patch_mask
from vidstyle.regions.patch_renderer import OpenRenderer, PatchRenderer
from vidstyle.regions.patches import PatchPlanner, PatchSet, plane_area
from vidstyle.regions.rasters import NO_RASTER, PageRaster, raster_of
from vidstyle.regions.writing.lifting import Strokes, lift_writing
from vidstyle.regions.writing.stroke_drawing import draw_writing
from vidstyle.stabilize.still import flatten_still
from vidstyle.style import Style

FACE_RATIOS = 0.36, 0.4
"""Heights of faces relative to the picture's shorter side. Focus is complete up to the first; from the second
on there is none, as marks are small enough for the face."""


class FaceSource(Protocol):
    """Returns the faces of pictures: `FaceFollower` of films, `StillFaces` of pictures."""

    @property
    def detail(self) -> float:
        """Level of detail that the faces of a picture or a scene need; see `automatic_detail`."""

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
        features: eyes, noses and mouths of small faces, which are drawn over the faces.
        light: more light on dim faces; None if there are none.
    """

    page: PendingPicture
    faces: Sequence[tuple[PendingPicture, PatchSet]]
    features: Sequence[Features]
    writing: PictureEdit[list[Strokes]]
    style: Style
    region: np.ndarray | None
    raster: PageRaster
    light: PictureEdit[list[Rectangle]] | None

    def result(self) -> Picture:
        """The restyled picture; waits for it."""
        page = styled = self.page.result()
        for fine, patches in self.faces:
            page = lay_over(page, styled, fine.result(), patches, self.region, self.raster.cell)
        if self.features:
            page = draw_features(page, self.features, self.style, self.region, self.raster)
        if strokes := self.writing.kept():
            page = draw_writing(page, strokes, self.style, self.region, self.raster.cell)
        return page

    def covers(self, shape: tuple[int, int]) -> np.ndarray:
        """Return where focus may change a picture of this shape, H x W bool."""
        whole = np.zeros(shape, bool)
        for _, patches in self.faces:
            for patch in patches.visible:
                whole[plane_area(patch.window, (1, 1))] |= patch_mask(patch, self.raster.cell) > 0
        light = self.light.kept() if self.light else []
        for window in light + [each.window for each in self.writing.kept()]:
            whole[plane_area(window, (1, 1))] = True
        return whole


class FocusRenderer(Backend):
    """Restyles pictures, and their faces a second time in finer detail; crowds in finer detail as a whole.

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
        cuts: SceneCuts | None = None,
        side_ratio: float = 1.0,
    ) -> None:
        self._chosen = self._style = style
        self._side_ratio, self._detail = side_ratio, 1.0
        self._page = open_backend(style, cuts)
        # Two sets of patches, while one replaces the other.
        self._patches = PatchRenderer(open_backend, side_ratio), PatchRenderer(open_backend, side_ratio)
        self._source, self._planner, self._dim = faces, PatchPlanner(), DimFaces()
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
        self._chosen = style
        self._style = with_detail(style, self._detail)
        self._page.change_style(self._style)

    def restyle(self, request: FrameRequest) -> Picture:
        """Restyle a picture, then its faces; see `Backend.restyle`."""
        return self._start(request, lambda backend, each: completed_future(backend.restyle(each))).result()

    def begin(self, request: FrameRequest) -> PendingPicture:
        """Find the faces of a picture, and start to restyle the picture and the faces.

        On the CPU, the thread that finishes the last of these lays them over each other.
        """
        started = self._start(request, lambda backend, each: backend.begin(each))
        if not isinstance(started, FocusedPicture):
            return started
        parts = [started.page, *(fine for fine, _ in started.faces)]
        futures = [each for each in parts if isinstance(each, Future)]
        return joined_future(futures, started.result) if len(futures) == len(parts) else started

    def _start(
        self, request: FrameRequest, start: Callable[[Backend, FrameRequest], PendingPicture]
    ) -> PendingPicture:
        request = flatten_still(request, self._style.steady)
        if not self._is_focused:
            return start(self._page, request)
        found, tones = self._follow(request), SharedTones()
        style = self._style
        sets = self._plan(request, found)
        light = self._light(request, found)
        writing = PictureEdit(light or request.picture, partial(lift_writing, amount=style.focus))
        request = replace(request, edit=writing)
        if request.time is None:
            request = request.edited()
            if not (sets or light or writing.kept()):
                return start(self._page, request)
        page = start(self._page, replace(request, measured=tones) if sets else request)
        lifted = replace(request.edited(), tones=tones) if sets else request
        faces = list[tuple[PendingPicture, PatchSet]]()
        features = dict[int, Features]()
        for patches in sets:
            backend, fine, marked = self._prepare(lifted, patches)
            faces.append((start(backend, fine), patches))
            features |= {each.face.track: each for each in marked}
        region, raster = _region(request.picture, style), self._raster_on(request)
        return FocusedPicture(page, faces, list(features.values()), writing, style, region, raster, light)

    def skip(self, request: FrameRequest) -> None:
        """Follow faces and their tones through a picture that is not restyled."""
        if not self._is_focused:
            return
        found = self._follow(request)
        light, sets = self._light(request, found), self._plan(request, found)
        if light and sets:
            request = replace(request, picture=light.picture())
        for patches in sets:
            self._patches_of(patches).cut(request, patches, self._style.focus, *self._drawing(request))

    def overlay(self, picture: Picture, seen_side: float | None = None) -> np.ndarray | None:
        """Return what focus changes in a single picture, to be laid over it by other means.

        Args:
            picture: any picture.
            seen_side: see `FrameRequest`.

        Returns:
            H x W x 4 uint8, RGB with the changed parts as alpha; None if there are none.
        """
        target = Encoding(full_range=True, subsampling=(1, 1))
        started = self._start(
            FrameRequest(picture, None, target, rgb=True, seen_side=seen_side),
            lambda backend, each: completed_future(backend.restyle(each)),
        )
        changed = np.full(picture.shape, self._style != self._chosen)
        if isinstance(started, FocusedPicture):
            changed |= started.covers(picture.shape)
        elif not changed.any():
            return None
        color = started.result().color
        assert color is not None
        return np.dstack([color, 255 * changed.astype(np.uint8)])

    def _light(self, request: FrameRequest, faces: Sequence[Face]) -> PictureEdit[list[Rectangle]] | None:
        """Return the edit that lights the dim faces of the next picture; None if there are none.

        Where a style keeps parts of the source, these must not have other tones.
        """
        if self._style.only or self._style.keep:
            return None
        dim = self._dim.follow(request.picture, faces, request.time)
        edit = partial(light_faces, faces=dim, amount=self._style.focus)
        return PictureEdit(request.picture, edit) if dim else None

    def _follow(self, request: FrameRequest) -> tuple[Face, ...]:
        """Return the faces of the next picture, and use the style as fine as they and its size need it."""
        found, before = self._source.follow(request.picture, request.time), self._detail
        seen_side = request.seen_side or self._side_ratio * min(request.picture.shape)
        self._detail = self._source.detail * small_picture_detail(seen_side)
        if self._detail != before:
            self.change_style(self._chosen)
        return found

    @property
    def _is_focused(self) -> bool:
        return bool(self._style.focus) and self._style.height is not None and not self._style.is_plain

    def _prepare(
        self, request: FrameRequest, patches: PatchSet
    ) -> tuple[Backend, FrameRequest, list[Features]]:
        raster, (amount, _) = self._raster_on(request), self._drawing(request)
        assert self._style.height is not None and self._chosen.height is not None
        fineness = self._style.height / self._chosen.height
        return self._patches_of(patches).prepare(request, patches, self._style, amount, raster, fineness)

    def _drawing(self, request: FrameRequest) -> tuple[float, Medium]:
        """Return how much of the features is drawn over faces, 0..1; and in what."""
        medium = Medium.of(self._style, self._raster_on(request))
        return min(1.0, self._style.focus / FULL_FOCUS), medium

    def _patches_of(self, patches: PatchSet) -> PatchRenderer:
        return self._patches[patches.number % len(self._patches)]

    def _plan(self, request: FrameRequest, found: Sequence[Face]) -> list[PatchSet]:
        """Return the patches for the faces that need finer detail."""
        picture = request.picture
        side = self._side_ratio * min(picture.shape)
        small = [replace(face, opacity=face.opacity * _small_share(face, side)) for face in found]
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


def _small_share(face: Face, side: float) -> float:
    """Return how much finer detail a face gets: less, the larger it is relative to the shorter side."""
    small, large = FACE_RATIOS
    return min(1.0, max(0.0, (large - face.box.height / side) / (large - small)))


def _region(picture: Picture, style: Style) -> np.ndarray | None:
    """Return where a style applies, by its `only` and `keep`: H x W float32, 0..1; None: everywhere."""
    inside = picture.masks[style.only] if style.only else None
    if style.keep:
        kept = cv2.bitwise_not(picture.masks[style.keep])
        inside = kept if inside is None else cv2.multiply(inside, kept, scale=1 / 255)
    return None if inside is None else inside * np.float32(1 / 255)
