"""Resizes pictures plane by plane, keeping the chroma siting."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import UsageError

MIN_BLUR_DEVIATION = 0.1
"""Standard deviation in samples below which a Gaussian is skipped."""


def output_size(wanted: tuple[int, int], width: int, height: int) -> tuple[int, int]:
    """Return width and height; one of `wanted` may be -1 to keep the aspect ratio, -2 to make it even, too.

    Raises:
        UsageError: the size is invalid.

    >>> output_size((640, -2), 1920, 1078)
    (640, 360)
    """
    across, down = wanted
    if min(across, down) < -2 or 0 in wanted or max(across, down) < 0:
        raise UsageError(
            f"size {across}x{down}", "is not a size", "give WxH in pixels, one of them perhaps -1 or -2"
        )
    if across < 0:
        across = _round_length(down * width / height, even=across == -2)
    elif down < 0:
        down = _round_length(across * height / width, even=down == -2)
    return across, down


def _round_length(length: float, even: bool) -> int:
    return max(2, 2 * round(length / 2)) if even else max(1, round(length))


def reduce_picture(picture: np.ndarray, side: int) -> np.ndarray:
    """Reduce an H x W or H x W x 3 array so that its longer side is at most `side` pixels."""
    import cv2

    factor = side / max(picture.shape[:2])
    if factor >= 1:
        return picture
    size = max(1, round(picture.shape[1] * factor)), max(1, round(picture.shape[0] * factor))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


def resize_picture(picture: Picture, width: int, height: int) -> Picture:
    """Resize a picture: area averaging when shrinking, bicubic interpolation when enlarging."""
    old_height, old_width = picture.shape
    if (old_width, old_height) == (width, height):
        return picture
    scales = width / old_width, height / old_height
    chroma_shape = picture.encoding.chroma_shape(height, width)

    def resize(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind == "chroma":
            return _resize_chroma(plane, picture.encoding, scales, chroma_shape)
        return _resize_plane(plane, (height, width))

    return picture.map_planes(resize)


def letterbox_picture(picture: Picture, width: int, height: int) -> Picture:
    """Fit a picture into another size, with black bars."""
    old_height, old_width = picture.shape
    scale = min(width / old_width, height / old_height)
    inner_width = min(width, max(1, round(old_width * scale)))
    inner_height = min(height, max(1, round(old_height * scale)))
    inner = resize_picture(picture, inner_width, inner_height)
    across, down = picture.encoding.subsampling
    left = (width - inner_width) // 2 // across * across
    top = (height - inner_height) // 2 // down * down
    encoding = picture.encoding
    opaque = 2**encoding.depth - 1 if encoding.depth else 1
    black, neutral = round(encoding.luma_levels[0]), round(encoding.chroma_levels[0])
    fills = {"luma": black, "chroma": neutral, "color": 0, "alpha": opaque}

    def frame(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind == "chroma":
            shape, (y, x) = encoding.chroma_shape(height, width), (top // down, left // across)
        else:
            shape, (y, x) = (height, width), (top, left)
        framed = np.full(shape + plane.shape[2:], fills[kind], plane.dtype)
        framed[y : y + plane.shape[0], x : x + plane.shape[1]] = plane
        return framed

    return inner.map_planes(frame)


def stretch_to_square_pixels(color: np.ndarray, sample_aspect: Fraction | None) -> np.ndarray:
    """Stretch the width of an H x W x 3 picture to square pixels; `sample_aspect` None: unchanged."""
    width = max(1, round(color.shape[1] * (sample_aspect or 1)))
    return color if width == color.shape[1] else _resize_plane(color, (color.shape[0], width))


def _resize_plane(plane: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Resize a plane by mapping pixel areas, not pixel centres."""
    import cv2

    shrinks = shape[0] <= plane.shape[0] and shape[1] <= plane.shape[1]
    method = cv2.INTER_AREA if shrinks else cv2.INTER_CUBIC
    return cv2.resize(plane, (shape[1], shape[0]), interpolation=method)


def _resize_chroma(
    plane: np.ndarray, encoding: Encoding, scales: tuple[float, float], shape: tuple[int, int]
) -> np.ndarray:
    """Resample a chroma plane for luma of another size, keeping the siting.

    The new sample j is at the new luma pixel siting + step j, which is mapped to its position in the source.
    """
    import cv2

    spread = [0.5 * max(1 / scale**2 - 1, 0) ** 0.5 for scale in scales]
    if max(spread) > MIN_BLUR_DEVIATION:
        across, down = (max(sigma, MIN_BLUR_DEVIATION) for sigma in spread)
        plane = cv2.GaussianBlur(plane, (0, 0), across, sigmaY=down, borderType=cv2.BORDER_REPLICATE)
    places = zip(encoding.siting, encoding.subsampling, scales, strict=True)
    x, y = (((first + 0.5) / scale - 0.5 - first) / step for first, step, scale in places)
    where = np.array([[1 / scales[0], 0, x], [0, 1 / scales[1], y]])
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(plane, where, shape[::-1], flags=flags, borderMode=cv2.BORDER_REPLICATE)
