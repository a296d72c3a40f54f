"""A renderer for styles that read masks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from vidstyle.backend import Backend, FrameRequest, PendingPicture
from vidstyle.core.picture import Picture
from vidstyle.style import Style
from vidstyle.style.resolve import masks_read

if TYPE_CHECKING:
    import numpy as np

    from vidstyle.core.scene_cuts import SceneCuts
    from vidstyle.regions.frame_masks import FrameMasks


class MaskRenderer(Backend):
    """Adds to each picture the masks that the style reads, and restyles it.

    Args:
        style: the style.
        open_backend: opens the renderer that restyles.
        cuts: scene cuts of the film; None: they are detected.

    Attributes:
        device_kind: see `Backend`.
    """

    def __init__(
        self, style: Style, open_backend: Callable[[], Backend], cuts: SceneCuts | None = None
    ) -> None:
        self._cuts = cuts
        self._key = _key(style)
        self._masks = _open_masks(style, cuts)
        self._backend = open_backend()
        self.device_kind = self._backend.device_kind

    @property
    def frames_in_flight(self) -> int:
        """See `Backend`."""
        return self._backend.frames_in_flight

    def cancel(self) -> None:
        """Give up the pictures in flight; see `Backend.cancel`."""
        self._backend.cancel()

    def close(self) -> None:
        """Close the renderer, and end the search for faces."""
        if self._masks is not None:
            self._masks.close()
        self._backend.close()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        if _key(style) != self._key:
            masks = _open_masks(style, self._cuts)
            if self._masks is not None:
                self._masks.close()
            self._key, self._masks = _key(style), masks
        self._backend.change_style(style)

    def overlay(self, picture: Picture, seen_side: float | None = None) -> np.ndarray | None:
        """Return the faces of a single picture alone; see `FocusRenderer.overlay`, which restyles them."""
        from vidstyle.regions.focus import FocusRenderer

        assert isinstance(self._backend, FocusRenderer)
        return self._backend.overlay(self._with_masks(FrameRequest(picture)).picture, seen_side)

    def restyle(self, request: FrameRequest) -> Picture:
        """Compute the masks of a picture, and restyle it; see `Backend.restyle`."""
        return self._backend.restyle(self._with_masks(request))

    def begin(self, request: FrameRequest) -> PendingPicture:
        """Compute the masks of a picture, and start to restyle it."""
        return self._backend.begin(self._with_masks(request))

    def skip(self, request: FrameRequest) -> None:
        """Compute the masks of a picture that is not restyled, as later masks depend on them."""
        self._backend.skip(self._with_masks(request))

    def memory(self) -> Sequence[np.ndarray]:
        """Return the memory of the renderer that restyles, without the masks. See `Backend.memory`."""
        return self._backend.memory()

    def _with_masks(self, request: FrameRequest) -> FrameRequest:
        if self._masks is None:
            return request
        picture = request.picture
        return replace(request, picture=replace(picture, masks=self._masks.of(picture, request.time)))


def _open_masks(style: Style, cuts: SceneCuts | None) -> FrameMasks | None:
    """Return what computes the masks of a style; None if it reads none, so that nothing heavy is imported."""
    if not masks_read(style):
        return None
    from vidstyle.regions.frame_masks import FrameMasks

    return FrameMasks(style, cuts)


def _key(style: Style) -> tuple[object, ...]:
    """Return what the masks of a style depend on."""
    return masks_read(style), style.masks, style.folder
