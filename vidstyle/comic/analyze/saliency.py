"""Saliency without a learned model: maps, the salient box, small objects, and attention under balloons."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.regions.boxes import Box
from vidstyle.regions.faces import is_colorful, skin_map

# The salient box.
SALIENT_BOX_SHARE = 0.85
"""Share of all saliency that the salient box of a picture contains."""
HEAD_ROOM_RATIO = 0.25
"""The salient box is enlarged upwards by this fraction of its height: the head above a salient body."""
_SPECTRAL_SIDE_PX = 64
"""Longer side of the copy whose spectrum is analysed."""
_MAX_SKIN_SHARE = 0.6
"""Share of skin colour in a picture from which skin is ignored."""
_SKIN_BLUR_RATIO = 1.5 / 64
"""Standard deviation of the Gaussian over skin, relative to the longer side; it removes single pixels."""
_BOX_GRID_CELLS = 24
"""Cells along the longer side of the grid on which box edges are placed."""

# Small conspicuous objects.
_BLOB_SIDE_PX = 128
"""Longer side of the copy in which blobs are found."""
_BLOB_DEVIATIONS_PX = (1.5, 3.0, 6.0)
"""Standard deviations of the inner Gaussians; the surrounds are twice as wide."""
_MIN_BLOB_CONTRAST = 18.0
"""Minimum difference of a blob from its surround, in Lab with 255 levels per channel."""
_MIN_BLOB_SHARE, _MAX_BLOB_SHARE = 0.0015, 0.12
"""Range of the share of the picture that a blob covers: less is detail, more is background."""
_MAX_BLOB_GAP_RATIO = 0.02
"""Maximum gap between blobs that are joined, such as letters of a word, relative to the longer side."""

# Attention maps, which show where balloons would cover something.
ATTENTION_SIDE_CELLS = 96
"""Cells of an attention map along the longer side."""
_ATTENTION_SIDE_PX = 256
"""Longer side of the copy that is analysed for an attention map."""
_SKIN_WEIGHT = 1.5
"""Additional weight of skin, which may be an undetected face."""
_OBJECT_ATTENTION_LEVEL = 4.0
"""Attention of small conspicuous objects: half a ball behind a caption is worse than a textured ground."""
_HAIR_HEIGHT_RATIO = 0.18
"""Attention extends upwards by this fraction of the height, to the hair above an undetected face."""


def saliency_map(color: np.ndarray, faces: Sequence[Box] = ()) -> np.ndarray:
    """Return the saliency of each pixel.

    It combines the spectral residual, sharpness, rare colours, skin, faces and a centre bias.

    Args:
        color: H x W x 3 uint8.
        faces: boxes in its pixels.

    Returns:
        H x W float32, 0..1.
    """
    height, width = color.shape[:2]
    small = _shrink(color, _SPECTRAL_SIDE_PX / max(height, width), 8)
    size = small.shape[1], small.shape[0]
    luma = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY).astype(np.float32)
    detail = cv2.resize(np.abs(cv2.Laplacian(luma, -1)), size, interpolation=cv2.INTER_AREA)
    seen = _normalize(_spectral_residual(small)) + 0.5 * _normalize(cv2.GaussianBlur(detail, (0, 0), 2))
    seen = seen + 0.5 * _normalize(_color_rarity(small)) + skin_saliency(small)
    seen *= _center_bias(size)
    seen = cv2.resize(seen, (width, height), interpolation=cv2.INTER_LINEAR)
    for face in faces:
        seen[int(face.top) : int(face.bottom), int(face.left) : int(face.right)] += 2 * seen.max()
    return _normalize(seen)


def salient_box(saliency: np.ndarray, share: float = SALIENT_BOX_SHARE) -> Box:
    """Return the smallest box with a share of the saliency, H x W, enlarged upwards by `HEAD_ROOM_RATIO`.

    It is the whole picture if the map is 0 everywhere.
    """
    height, width = saliency.shape
    cell = max(height, width) / _BOX_GRID_CELLS
    rows, columns = max(1, round(height / cell)), max(1, round(width / cell))
    cells = cv2.resize(saliency, (columns, rows), interpolation=cv2.INTER_AREA).astype(np.float64)
    cells = np.maximum(cells - np.median(cells), 0)
    if cells.sum() <= 0:
        return Box(0, 0, width, height)
    sums = np.pad(cells.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    tops, bottoms = np.triu_indices(rows + 1, 1)
    lefts, rights = np.triu_indices(columns + 1, 1)
    bands = sums[bottoms] - sums[tops]
    held = bands[:, rights] - bands[:, lefts]
    areas = np.outer(bottoms - tops, rights - lefts).astype(np.float64)
    # Among boxes of the same area, the one with the most saliency wins.
    costs = np.where(held >= share * cells.sum() - 1e-9, areas - held / cells.sum(), np.inf)
    band, across = np.unravel_index(int(np.argmin(costs)), costs.shape)
    x, y = width / columns, height / rows
    top = tops[band] - HEAD_ROOM_RATIO * (bottoms[band] - tops[band])
    return Box(
        float(lefts[across] * x),
        max(0.0, float(top * y)),
        float(rights[across] * x),
        float(bottoms[band] * y),
    )


def _shrink(picture: np.ndarray, factor: float, least: int = 1) -> np.ndarray:
    """Reduce a picture by a factor, to at least `least` pixels a side."""
    height, width = picture.shape[:2]
    size = max(least, round(width * factor)), max(least, round(height * factor))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


def _spectral_residual(small: np.ndarray) -> np.ndarray:
    """Return the spectral residual saliency (Hou and Zhang 2007)."""
    luma = cv2.cvtColor(small, cv2.COLOR_RGB2GRAY).astype(np.float32)
    spectrum = np.fft.fft2(luma)
    heights = np.log(np.abs(spectrum) + 1e-3).astype(np.float32)
    residual = heights - cv2.blur(heights, (3, 3), borderType=cv2.BORDER_REFLECT)
    seen = np.abs(np.fft.ifft2(np.exp(residual + 1j * np.angle(spectrum)))) ** 2
    return cv2.GaussianBlur(seen.astype(np.float32), (0, 0), 2.5)


def _color_rarity(small: np.ndarray) -> np.ndarray:
    """Return the distance of each colour from the picture's mean colour (Achanta et al. 2009)."""
    lab = cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 1), cv2.COLOR_RGB2LAB).astype(np.float32)
    return np.linalg.norm(lab - lab.mean(axis=(0, 1)), axis=2).astype(np.float32)


def skin_saliency(small: np.ndarray) -> np.ndarray:
    """Return the saliency of skin, H x W float32, 0..1.

    It is lower if large areas have the colour of skin, such as sand, wood or evening light.
    """
    if not is_colorful(small):
        return np.zeros(small.shape[:2], np.float32)
    skin = skin_map(small)
    return max(0.0, 1 - float(skin.mean()) / _MAX_SKIN_SHARE) * cv2.GaussianBlur(
        skin, (0, 0), max(small.shape) * _SKIN_BLUR_RATIO
    )


def _center_bias(size: tuple[int, int]) -> np.ndarray:
    """Return the centre bias: 1 in the middle, about half at the edges."""
    across, down = (np.linspace(-1, 1, length, dtype=np.float32) for length in size)
    return np.exp(-0.35 * (across[np.newaxis] ** 2 + down[:, np.newaxis] ** 2))


def _normalize(plane: np.ndarray) -> np.ndarray:
    low, high = float(plane.min()), float(plane.max())
    return (plane - low) / max(high - low, 1e-6) if high - low > 1e-6 else np.zeros_like(plane)


def find_blobs(color: np.ndarray) -> list[Box]:
    """Return boxes of the small conspicuous objects in a picture, H x W x 3 uint8; they do not overlap."""
    gap, apart = _MAX_BLOB_GAP_RATIO * max(color.shape), list[Box]()
    for blob in _components(color):
        while near := next((each for each in apart if _is_near(each, blob, gap)), None):
            apart.remove(near)
            blob = blob.union(near)
        apart.append(blob)
    return apart


def blob_map(color: np.ndarray) -> np.ndarray:
    """Return the centre-surround difference of each pixel of a picture, H x W x 3 uint8: H x W, 0..1."""
    lab = _small_lab(color)
    most = np.max([_center_surround(lab, scale) for scale in _BLOB_DEVIATIONS_PX[1:]], axis=0)
    return cv2.resize(np.minimum(1, most / (2 * _MIN_BLOB_CONTRAST)), (color.shape[1], color.shape[0]))


def _small_lab(color: np.ndarray) -> np.ndarray:
    """Return a small copy in Lab, float32."""
    small = _shrink(color, min(1.0, _BLOB_SIDE_PX / max(color.shape[:2])))
    return cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32)


def _is_near(one: Box, other: Box, gap: float) -> bool:
    across = max(one.left, other.left) - min(one.right, other.right)
    return max(across, max(one.top, other.top) - min(one.bottom, other.bottom)) <= gap


def _components(color: np.ndarray) -> Iterator[Box]:
    height, width = color.shape[:2]
    small = _small_lab(color)
    size = small.shape[1], small.shape[0]
    for scale in _BLOB_DEVIATIONS_PX:
        out = _center_surround(small, scale) > _MIN_BLOB_CONTRAST
        _, _, found, _ = cv2.connectedComponentsWithStats(out.astype(np.uint8), connectivity=8)
        for left, top, wide, high, area in found[1:]:
            if _MIN_BLOB_SHARE < area / out.size and wide * high < _MAX_BLOB_SHARE * out.size:
                # The response is smaller than the object by the width of its soft edge.
                x, y = width / size[0], height / size[1]
                yield Box(
                    max(0.0, (left - scale) * x),
                    max(0.0, (top - scale) * y),
                    min(float(width), (left + wide + scale) * x),
                    min(float(height), (top + high + scale) * y),
                )


def _center_surround(lab: np.ndarray, scale: float) -> np.ndarray:
    """Return the centre-surround difference in Lab: H x W float32."""
    near, around = (
        cv2.GaussianBlur(lab, (0, 0), deviation, borderType=cv2.BORDER_REPLICATE)
        for deviation in (scale, 2 * scale)
    )
    return np.asarray(np.linalg.norm(near - around, axis=2), np.float32)


def attention_map(color: np.ndarray, faces: Sequence[Box] = ()) -> np.ndarray:
    """Return the attention map of a picture, H x W x 3 uint8: float32, mean 1; bubbles avoid high values."""
    factor = _ATTENTION_SIDE_PX / max(color.shape[:2])
    small = _shrink(color, factor, 8)
    seen = saliency_map(small, [face.scaled(factor) for face in faces])
    seen += _SKIN_WEIGHT * skin_saliency(small) + blob_map(small)
    coarse = _shrink(seen, ATTENTION_SIDE_CELLS / _ATTENTION_SIDE_PX)
    above = np.ones((1 + round(_HAIR_HEIGHT_RATIO * len(coarse)), 1), np.uint8)
    spread = cv2.dilate(coarse, above, anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
    attention = (spread / max(float(spread.mean()), 1e-6)).astype(np.float32)
    cells = len(coarse) / len(small)
    for blob in _components(small):
        left, top, right, bottom = map(round, blob.scaled(cells))
        attention[top:bottom, left:right] = np.maximum(
            attention[top:bottom, left:right], _OBJECT_ATTENTION_LEVEL
        )
    return attention


def box_attention(key_frame: KeyFrame) -> np.ndarray:
    """Return an attention map that contains only the salient box."""
    factor = ATTENTION_SIDE_CELLS / max(key_frame.shape)
    seen = np.zeros([max(1, round(side * factor)) for side in key_frame.shape], np.float32)
    box = key_frame.saliency.scaled(factor)
    seen[round(box.top) : round(box.bottom), round(box.left) : round(box.right)] = 1
    return seen / max(float(seen.mean()), 1e-6)


def crop_attention(attention: np.ndarray, key_frame: KeyFrame, window: Box) -> np.ndarray:
    """Return the part of a key frame's map inside a window of its picture, at least one cell."""
    rows, columns = attention.shape
    down, across = rows / key_frame.shape[0], columns / key_frame.shape[1]
    top, left = min(rows - 1, int(window.top * down)), min(columns - 1, int(window.left * across))
    bottom, right = max(top + 1, round(window.bottom * down)), max(left + 1, round(window.right * across))
    return attention[top:bottom, left:right]


def mean_under(attention: np.ndarray, picture: Box, boxes: np.ndarray) -> np.ndarray:
    """Return the mean of a picture's map under each of the boxes that are inside the picture.

    Args:
        attention: rows x columns.
        picture: box of the picture.
        boxes: left, top, right, bottom: count x 4.
    """
    rows, columns = attention.shape
    sums = np.pad(attention.cumsum(0, dtype=np.float64).cumsum(1), ((1, 0), (1, 0)))
    x = (boxes[:, [0, 2]] - picture.left) * (columns / picture.width)
    y = (boxes[:, [1, 3]] - picture.top) * (rows / picture.height)
    left = np.clip(np.floor(x[:, 0]).astype(int), 0, columns - 1)
    top = np.clip(np.floor(y[:, 0]).astype(int), 0, rows - 1)
    right = np.clip(np.ceil(x[:, 1]).astype(int), left + 1, columns)
    bottom = np.clip(np.ceil(y[:, 1]).astype(int), top + 1, rows)
    total = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
    return total / ((right - left) * (bottom - top))
