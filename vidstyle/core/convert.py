"""Convert a picture to another encoding, to packed RGB or to an array, without a renderer.

`Picture.from_array` is the way back from an array.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vidstyle.core.bands import in_bands, shared_workers
from vidstyle.core.codes import IDENTITY_MIX_WEIGHTS, Chroma, chroma_radius, store, store_chroma, store_yuv
from vidstyle.core.color.deferred_color import Printed
from vidstyle.core.color.hdr_curves import light_conversion
from vidstyle.core.kernels import interleaved
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.planes import alpha_in_depth, chroma_rows, color_rows, luma_rows

ONE_THREAD_PIXELS = 1 << 17
"""Smaller pictures are converted in the calling thread: handing bands out would take longer."""


def convert(picture: Picture, target: Encoding, rgb: bool = False) -> Picture:
    """Return the picture in another encoding; the picture itself if it has this encoding.

    Chroma planes on the same grid are not resampled, and with the same codes not copied. Values outside
    the range of the numbers are clipped. Between transfer functions, `light_conversion` converts RGB.

    Args:
        picture: any picture; its planes are only read.
        target: the encoding wanted.
        rgb: packed RGB instead of luma and chroma; of the target only its depth and transfer count then.

    >>> convert(Picture.from_array(np.full((2, 2), 255, np.uint8)), Encoding()).luma.tolist()
    [[235, 235], [235, 235]]
    """
    if target == picture.encoding and rgb == (picture.color is not None):
        return picture
    assembler = PictureAssembler(picture, target, rgb)
    put = _row_converter(picture, assembler, rgb)
    height, width = picture.shape
    if height * width < ONE_THREAD_PIXELS:
        put(0, height)
    else:
        in_bands(shared_workers(), picture.shape, 0, put)
    return assembler.picture()


def to_rgb(picture: Picture, depth: int = 8) -> np.ndarray:
    """Return the picture as an H x W x 3 RGB array, transparent parts blended with white.

    Args:
        picture: any picture; a packed RGB picture of this depth is not copied.
        depth: up to 8 for uint8, up to 16 for uint16, both full range; 0 for float32 in 0..1.
    """
    shown = convert(picture, Encoding(full_range=True, depth=depth, subsampling=(1, 1)), rgb=True)
    assert shown.color is not None
    if shown.alpha is None:
        return np.ascontiguousarray(shown.color)
    white = np.float32(shown.encoding.luma_levels[1])
    alpha = shown.alpha[..., np.newaxis] / white
    blended = shown.color * alpha + white * (1 - alpha)
    return (blended if depth == 0 else np.rint(blended)).astype(shown.color.dtype)


class PictureAssembler:
    """Assembles a picture of a given encoding from bands of float32 rows, from any number of threads."""

    def __init__(self, source: Picture, target: Encoding, rgb: bool) -> None:
        """Size and alpha of the result come from `source`; `rgb` has the same meaning as for `convert`."""
        self.target = replace(target, full_range=True, subsampling=(1, 1)) if rgb else target
        self._source = source
        self._color = np.empty((*source.shape, 3), target.dtype) if rgb else None
        self._luma = None if rgb else np.empty(source.shape, target.dtype)
        # Made here, not by the first band with chroma: two bands may be that one. Costs nothing unused.
        shape = target.chroma_shape(*source.shape)
        self._chroma = np.empty(shape, target.dtype), np.empty(shape, target.dtype)
        self._has_chroma = False

    def put_color(self, top: int, bottom: int, above: int, color: np.ndarray | Printed) -> None:
        """Store RGB, 0..1, as such or as luma and chroma, for the rows top..bottom.

        Args:
            top, bottom: a multiple of the chroma step, and another one or the last row.
            above: rows of `color`, N x W x 3, that lie above `top`; `chroma_radius` returns the number
                that chroma is averaged over.
        """
        if self._color is None:
            assert self._luma is not None
            self._has_chroma = True
            store_yuv(color, above, self.target, self._luma[top:bottom], self._chroma_rows(top, bottom))
            return
        color = color.whole() if isinstance(color, Printed) else color
        color, out = color[above : above + bottom - top], self._color[top:bottom]
        if self.target.depth == 0:
            np.clip(color, 0, 1, out=out)
        else:
            levels = self.target.luma_levels
            store(interleaved(color), *levels, self.target.depth, interleaved(out))

    def put_luma(self, top: int, luma: np.ndarray) -> None:
        """Store luma rows, N x W, 0..1, from row `top` on."""
        assert self._luma is not None
        store(luma, *self.target.luma_levels, self.target.depth, self._luma[top : top + len(luma)])

    def put_chroma(
        self,
        top: int,
        bottom: int,
        above: int,
        planes: tuple[np.ndarray, ...],
        mix: np.ndarray = IDENTITY_MIX_WEIGHTS,
    ) -> None:
        """Store chroma at luma's resolution, -0.5..0.5, for the rows of `put_color`.

        Args:
            above: rows of the planes that lie above `top`.
            planes: blue and red difference, or what they are sums of.
            mix: those sums, as `store_chroma` takes them.
        """
        self._has_chroma = True
        store_chroma(planes, mix, above, self.target, self._chroma_rows(top, bottom))

    def reuse_luma(self, luma: np.ndarray) -> None:
        """Use a luma plane with the target's codes, without a copy."""
        self._luma = luma

    def reuse_chroma(self, chroma: Chroma, encoding: Encoding) -> None:
        """Use chroma planes on the target's grid without resampling; with its codes, without a copy."""
        self._has_chroma = True
        self._chroma = _recoded_chroma(chroma, encoding, self.target)

    def _chroma_rows(self, top: int, bottom: int) -> Chroma:
        down = self.target.subsampling[1]
        blue, red = (plane[top // down : -(-bottom // down)] for plane in self._chroma)
        return blue, red

    def picture(self) -> Picture:
        """Return the finished picture; one without chroma gets neutral chroma planes."""
        alpha = alpha_in_depth(self._source, self.target.depth)
        if self._color is not None:
            return Picture(self.target, color=self._color, alpha=alpha)
        if not self._has_chroma:
            for plane in self._chroma:
                plane.fill(self.target.chroma_levels[0])
        return Picture(self.target, luma=self._luma, chroma=self._chroma, alpha=alpha)


def _row_converter(picture: Picture, assembler: PictureAssembler, rgb: bool) -> Callable[[int, int], None]:
    target = assembler.target
    is_gray = picture.color is None and picture.chroma is None
    same_matrix = picture.color is None and picture.encoding.matrix == target.matrix
    conversion = light_conversion(picture.encoding, target)
    through_rgb = rgb or conversion is not None or not (is_gray or same_matrix)
    reuses = not through_rgb and picture.chroma is not None and picture.encoding.has_grid_of(target)
    if reuses and picture.chroma is not None:
        assembler.reuse_chroma(picture.chroma, picture.encoding)
    above, below = chroma_radius(target)

    def put(top: int, bottom: int) -> None:
        first, last = max(top - above, 0), min(bottom + below, picture.shape[0])
        if through_rgb:
            color = color_rows(picture, first, last)
            color = conversion.apply(color) if conversion else color
            assembler.put_color(top, bottom, top - first, color)
            return
        assembler.put_luma(top, luma_rows(picture, top, bottom))
        if not is_gray and not reuses:
            assembler.put_chroma(top, bottom, top - first, chroma_rows(picture, first, last))

    return put


def _recoded_chroma(chroma: Chroma, old: Encoding, new: Encoding) -> Chroma:
    """Chroma planes in other codes on the same grid; themselves where the codes are the same."""
    if old == new:
        return chroma
    (neutral, span), (wanted, wanted_span) = old.chroma_levels, new.chroma_levels
    gain = wanted_span / span
    out = np.empty(chroma[0].shape, new.dtype), np.empty(chroma[0].shape, new.dtype)
    for plane, recoded in zip(chroma, out, strict=True):
        values = np.multiply(plane, np.float32(gain), dtype=np.float32)
        values += np.float32(wanted - gain * neutral)
        store(values, 0, 1, new.depth, recoded)
    return out
