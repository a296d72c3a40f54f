"""Colours of a restyled picture: one for each plane, and means around marks."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import values_from_codes
from vidstyle.core.sampling import percentiles
from vidstyle.regions.features.blurring import MIN_WEIGHT

DARK_SIZE_PX, DARK_SHARE, MAX_DARK_LUMA = (128, 72), 0.005, 0.25
"""Samples of a page across and down that are searched for its darkest colour; the share that counts as it;
and its luma at most."""

DRAWN_KINDS = "luma", "chroma", "color"
"""Kinds of planes that have colours; others are alpha and masks."""


def plane_colors(page: Picture, color: tuple[float, float, float]) -> list[np.ndarray]:
    """Return a colour, RGB 0..1, as one value or colour for each plane of `DRAWN_KINDS`."""
    luma, *chroma = page.encoding.yuv_from_color(color)
    planes = [
        *((luma,) if page.luma is not None else ()),
        *(chroma if page.chroma else ()),
        *((color,) if page.color is not None else ()),
    ]
    return [np.array(each, np.float32) for each in planes]


def darkest_colors(page: Picture) -> list[np.ndarray]:
    """Return the mean of the darkest samples of a page; see `plane_colors`.

    In a style of one ink, it is the ink. Of a page without darks, it is darkened at its hue.
    """
    samples = list[np.ndarray]()

    def sample(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind in DRAWN_KINDS:
            small = cv2.resize(plane, DARK_SIZE_PX, interpolation=cv2.INTER_NEAREST)
            samples.append(values_from_codes(small, kind, page.encoding))
        return plane

    page.map_planes(sample)
    luma = samples[0] if samples[0].ndim == 2 else cv2.transform(samples[0], page.encoding.weights[None])
    is_dark = luma <= percentiles(luma, [100 * DARK_SHARE])
    share = min(1.0, MAX_DARK_LUMA / max(float(luma[is_dark].mean()), MAX_DARK_LUMA))
    return [np.asarray(share * each[is_dark].mean(axis=0), np.float32) for each in samples]


def local_mean(values: np.ndarray, size: float, step: tuple[int, int]) -> np.ndarray:
    """Return the mean of the samples nearby."""
    return cv2.blur(values, (max(1, round(size / step[0])), max(1, round(size / step[1]))))


def masked_mean(values: np.ndarray, mask: np.ndarray, size: float, step: tuple[int, int]) -> np.ndarray:
    """Return the mean of the samples nearby that are in a mask of their height and width, 0..1."""
    mask = mask + np.float32(MIN_WEIGHT)
    return local_mean(values * mask, size, step) / local_mean(mask, size, step).reshape(mask.shape)
