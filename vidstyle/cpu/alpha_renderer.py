"""Restyles the edges of the alpha channel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from vidstyle.backend import Backend, FrameRequest, PendingPicture
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.planes import alpha_in_depth
from vidstyle.style import Style

EDGE_RATIO = 1 / 90
"""Distance from an edge of alpha within which it is restyled, relative to the height."""
MIN_EDGE_PX = 2
MIN_FLAT_CHANGE = 1 / 255
"""Alpha that changes less around a pixel is kept."""
MIN_CONTRAST = 0.25
"""Difference between the restyled opaque and clear below which a style says nothing about edges."""


def edge_style(style: Style) -> Style | None:
    """Return the part of a style that shapes edges of alpha, its areas without lines; None if it has none."""
    if not (style.base or style.background):
        return None
    plain = {name: getattr(Style, name) for name in ("paper", "steady", "only", "keep", "behind")}
    return replace(style, lines=(), focus=0.0, **plain)


@dataclass(frozen=True)
class PendingAlphaPicture:
    """A picture and its alpha channel that are being restyled; see `PendingPicture`."""

    alpha: np.ndarray
    color: PendingPicture
    edges: PendingPicture

    def result(self) -> Picture:
        """Wait for both, and return the picture with the new alpha."""
        return _with_edges(self.color.result(), self.alpha, self.edges.result())


class AlphaRenderer(Backend):
    """Restyles pictures, and the edges of their alpha as a white shape on black.

    Args:
        renderer: for the pictures; it is closed with this one.
        edges: for alpha, with the `edge_style`; it is closed with this one.
    """

    def __init__(self, renderer: Backend, edges: Backend) -> None:
        self._renderer, self._edges = renderer, edges
        self.device_kind = renderer.device_kind

    @property
    def frames_in_flight(self) -> int:
        """See `Backend`."""
        return self._renderer.frames_in_flight

    def begin(self, request: FrameRequest) -> PendingPicture:
        """Start to restyle a picture and its alpha."""
        pending, alpha = self._renderer.begin(request), request.picture.alpha
        if alpha is None:
            return pending
        return PendingAlphaPicture(alpha, pending, self._edges.begin(_as_gray(request)))

    def skip(self, request: FrameRequest) -> None:
        """See `Backend.skip`."""
        self._renderer.skip(request)

    def memory(self) -> Sequence[np.ndarray]:
        """See `Backend.memory`."""
        return self._renderer.memory()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on; edges keep theirs if it has no areas."""
        self._renderer.change_style(style)
        if edges := edge_style(style):
            self._edges.change_style(edges)

    def cancel(self) -> None:
        """See `Backend.cancel`."""
        self._renderer.cancel()
        self._edges.cancel()

    def close(self) -> None:
        """Close both renderers."""
        self._renderer.close()
        self._edges.close()


def _as_gray(request: FrameRequest) -> FrameRequest:
    """Return a request for the alpha channel as a gray picture, which has no memory of earlier ones."""
    encoding = Encoding(full_range=True, depth=request.picture.encoding.depth, subsampling=(1, 1))
    return FrameRequest(Picture(encoding, luma=request.picture.alpha), is_clean=True)


def _with_edges(picture: Picture, alpha: np.ndarray, edges: Picture) -> Picture:
    """Return the picture with the restyled alpha near edges, and its own alpha elsewhere."""
    top = edges.encoding.luma_levels[1]
    assert edges.luma is not None
    own, styled = (plane.astype(np.float32) / np.float32(top) for plane in (alpha, edges.luma))
    size = 2 * max(MIN_EDGE_PX, round(alpha.shape[0] * EDGE_RATIO)) + 1
    low, high = cv2.erode(own, np.ones((size, size))), cv2.dilate(own, np.ones((size, size)))
    clear, opaque = _level(styled[high <= 0], 0.0), _level(styled[low >= 1], 1.0)
    if opaque - clear >= MIN_CONTRAST:
        near = high - low > MIN_FLAT_CHANGE
        own = np.where(near, np.clip((styled - clear) / (opaque - clear), 0, 1), own)
    values = own if edges.encoding.depth == 0 else np.rint(own * top).astype(alpha.dtype)
    shape = Picture(edges.encoding, luma=values, alpha=values)
    return replace(picture, alpha=alpha_in_depth(shape, picture.encoding.depth))


def _level(values: np.ndarray, usual: float) -> float:
    return float(np.median(values)) if values.size else usual
