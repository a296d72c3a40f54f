"""Restyles patches in finer detail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from vidstyle.backend import Backend, FrameRequest
from vidstyle.core.closing import Closing
from vidstyle.core.picture import Picture
from vidstyle.core.scene_cuts import KnownCuts, SceneCuts
from vidstyle.regions.features.exposure import Exposure
from vidstyle.regions.features.feature_lifting import Features, lift_features
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.steady_darkness import SteadyDarkness
from vidstyle.regions.patches import PatchSet, cut_patches
from vidstyle.regions.rasters import PageRaster
from vidstyle.style import Style

FACE_DETAIL_RATIO = 0.38
"""Level of detail at `focus` 1, as of `--detail`, for a face as high as the picture; smaller ones get more.
Tuned on the pictures of `exposure`."""
DETAIL_RANGE, LARGE_RATIO = (2.4, 3.6), 0.62
"""Minimum and maximum level of detail at `focus` 1; and the level for a face as high as the picture, which
limits the minimum: a face of a third of the height needs less."""

SCREEN_DETAIL_RATIO, SCREEN_DETAIL_RANGE = 0.12, (1.0, 2.0)
"""The same for styles of dots or ruled lines: finer ones would look like another print."""

OpenRenderer = Callable[[Style, SceneCuts | None], Backend]
"""Opens a renderer for a style and scene cuts; None: they are detected."""


class PatchRenderer(Closing):
    """Restyles the patches of films as one picture, with a renderer that is opened for the first one.

    Args:
        open_backend: opens the renderer.
        side_ratio: see `FocusRenderer`.
    """

    def __init__(self, open_backend: OpenRenderer, side_ratio: float = 1.0) -> None:
        self._open, self._side_ratio = open_backend, side_ratio
        self._backend: Backend | None = None
        self._cuts, self._exposure, self._darkness = KnownCuts(()), Exposure(), SteadyDarkness()
        self._detailed: tuple[object, Style] | None = None

    def cancel(self) -> None:
        """Give up the pictures in flight; see `Backend.cancel`."""
        if self._backend is not None:
            self._backend.cancel()

    def close(self) -> None:
        """Close the renderer."""
        if self._backend is not None:
            self._backend.close()

    def prepare(
        self,
        request: FrameRequest,
        patches: PatchSet,
        style: Style,
        drawn: float,
        raster: PageRaster,
        fineness: float = 1.0,
    ) -> tuple[Backend, FrameRequest, list[Features]]:
        """Return the renderer of a picture of patches, the request for it, and the features to draw.

        Args:
            request: the whole picture.
            patches: the patches; the first of a set begin a scene.
            style: the style of the whole picture.
            drawn: how much of eyes, noses and mouths is drawn over the result, 0..1.
            raster: the rasters of the style.
            fineness: level of detail of the whole picture, by which that of patches is divided.
        """
        cut, features = self.cut(request, patches, style.focus, drawn, Medium.of(style, raster))
        share = patches.least / (self._side_ratio * min(request.picture.shape))
        is_ruled = raster.is_screen and not raster.has_points
        low, high = SCREEN_DETAIL_RANGE if is_ruled else DETAIL_RANGE
        low = min(low, max(1.0, LARGE_RATIO / share))
        ratio = SCREEN_DETAIL_RATIO if is_ruled else FACE_DETAIL_RATIO
        detail = max(1.0, min(max(ratio / share, low), high) ** style.focus / fineness)
        backend = self._use(style, detail, cut.shape, request.picture.shape)
        return backend, replace(request, picture=cut, target=request.encoding), features

    def cut(
        self, request: FrameRequest, patches: PatchSet, focus: float, drawn: float, medium: Medium
    ) -> tuple[Picture, list[Features]]:
        """Return the picture of all patches, with tones that suit the style by `focus`; and its features.

        There are none to draw where the medium draws faces itself.
        """
        if patches.is_new and request.time is not None:
            self._cuts.add(request.time)
            self._exposure, self._darkness = Exposure(), SteadyDarkness()
        picture = cut_patches(request.picture, patches.patches)
        faces = lift_features(picture, patches.patches, drawn, medium.lifted_share)
        features = [] if medium is Medium.POINTS else [each.features() for each in faces]
        if request.time is not None:
            features = self._darkness.follow(features)
        bare = {each.face.track: medium.lifted_share * each.amount for each in faces}
        self._exposure.apply(picture, patches.patches, request.picture, request.time, focus, bare)
        return picture, features

    def _use(self, style: Style, detail: float, patches: tuple[int, int], page: tuple[int, int]) -> Backend:
        """Return the renderer, with the style at this level of detail for this size of patches and page."""
        key = style, detail, patches, page
        if self._detailed is None or self._detailed[0] != key:
            assert style.height is not None
            height = style.height * min(patches) / min(page)
            # Where the source is kept, it must not be the one with adapted tones.
            self._detailed = key, replace(style, height=height, detail=detail, only="", keep="")
            if self._backend is not None:
                self._backend.change_style(self._detailed[1])
        if self._backend is None:
            self._backend = self._open(self._detailed[1], self._cuts)
        return self._backend
