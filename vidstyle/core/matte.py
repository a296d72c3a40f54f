"""A colour behind the transparent parts of a picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vidstyle.core.convert import convert
from vidstyle.core.picture import Encoding, Picture

RGB = Encoding(full_range=True, depth=0, subsampling=(1, 1))


def over_color(picture: Picture, color: tuple[float, float, float]) -> Picture:
    """Return a picture in front of a colour, without alpha; samples of opaque pixels stay unchanged.

    Args:
        picture: with straight alpha; one without alpha is returned itself.
        color: RGB 0..1 with the primaries and gamma of SDR.
    """
    if picture.alpha is None:
        return picture
    encoding = picture.encoding
    one_pixel = Picture(RGB, color=np.array([[color]], np.float32))
    matte = convert(one_pixel, replace(encoding, subsampling=(1, 1)), picture.color is not None)
    cover = picture.alpha.astype(np.float32) / np.float32(2**encoding.depth - 1 if encoding.depth else 1)
    if picture.color is not None:
        assert matte.color is not None
        return replace(picture, color=_mixed(picture.color, matte.color, cover[..., np.newaxis]), alpha=None)
    assert picture.luma is not None and matte.luma is not None and matte.chroma is not None
    import cv2

    shape = encoding.chroma_shape(*picture.shape)
    neutral = np.full(shape, encoding.chroma_levels[0], encoding.dtype)
    small = cv2.resize(cover, shape[::-1], interpolation=cv2.INTER_AREA)
    blue, red = (
        _mixed(plane, behind, small)
        for plane, behind in zip(picture.chroma or (neutral, neutral), matte.chroma, strict=True)
    )
    luma = _mixed(picture.luma, matte.luma, cover)
    return Picture(encoding, luma, (blue, red), masks=picture.masks)


def _mixed(plane: np.ndarray, behind: np.ndarray, cover: np.ndarray) -> np.ndarray:
    """Mix samples with the samples of one pixel."""
    base = behind[0, 0].astype(np.float32)
    values = base + (plane - base) * cover
    return values if plane.dtype.kind == "f" else np.rint(values).astype(plane.dtype)
