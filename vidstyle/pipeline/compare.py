"""Combines source and result into one picture."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from vidstyle.core.color.hdr_curves import diffuse_white
from vidstyle.core.picture import Picture
from vidstyle.media.options import VideoInfo

Compare = Literal["side", "split"]
"""side: the source on the left, the result on the right; split: the left half of the source and the right
half of the result, with a white line between them."""


def compare_info(info: VideoInfo, how: Compare | None) -> VideoInfo:
    """Return the properties of a film of compared pictures: twice as wide if they are side by side."""
    if how != "side":
        return info
    return replace(info, width=_whole_chroma(info.width, info.encoding.subsampling[0]) + info.width)


def compare_pictures(before: Picture, after: Picture, how: Compare) -> Picture:
    """Return both pictures in one; they have the same size, encoding and kinds of planes.

    >>> black, white = np.zeros((2, 7), np.uint8), np.full((2, 7), 255, np.uint8)
    >>> compare_pictures(Picture.from_array(black), Picture.from_array(white), "side").luma[0].tolist()
    [0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255]
    """
    step = 1 if before.luma is None else before.encoding.subsampling[0]
    width = before.shape[1]
    if how == "side":
        return _beside(_widened(before, _whole_chroma(width, step) - width), after)
    middle = width // 2 // step * step
    # Thin, but visible when a 4K film is shown in a small window.
    end = min(middle + step * max(1, width // 640 // step), width)
    line = _white(_columns(before, middle, end))
    return _beside(_columns(before, 0, middle), line, _columns(after, end, width))


def _whole_chroma(width: int, step: int) -> int:
    """Return the width up to the next whole chroma sample, so that both halves keep their own colours."""
    step = max(step, 2)
    return -(-width // step) * step


def _widened(picture: Picture, missing: int) -> Picture:
    def widen(plane: np.ndarray, kind: str) -> np.ndarray:
        # Subsampled chroma already ends on a whole sample.
        if kind == "chroma" and picture.encoding.subsampling[0] > 1:
            return plane
        return np.concatenate([plane, *[plane[:, -1:]] * missing], axis=1)

    return picture.map_planes(widen)


def _columns(picture: Picture, start: int, end: int) -> Picture:
    def cut(plane: np.ndarray, kind: str) -> np.ndarray:
        step = picture.encoding.subsampling[0] if kind == "chroma" else 1
        return plane[:, start // step : -(-end // step)]

    return picture.map_planes(cut)


def _white(picture: Picture) -> Picture:
    encoding = picture.encoding
    top = 1.0 if encoding.depth == 0 else 2**encoding.depth - 1
    (black, white), neutral = encoding.luma_levels, encoding.chroma_levels[0]
    luma = black + (white - black) * diffuse_white(encoding.transfer)
    values = {"luma": luma, "chroma": neutral, "color": top, "alpha": top}
    return picture.map_planes(lambda plane, kind: np.full_like(plane, values[kind]))


def _beside(first: Picture, *others: Picture) -> Picture:
    planes = [iter(_planes(other)) for other in others]
    return first.map_planes(
        lambda plane, _: np.concatenate([plane, *(next(each) for each in planes)], axis=1)
    )


def _planes(picture: Picture) -> list[np.ndarray]:
    """Return all planes, in the order of `map_planes`."""
    planes = picture.luma, *(picture.chroma or ()), picture.color, picture.alpha
    return [plane for plane in planes if plane is not None]
