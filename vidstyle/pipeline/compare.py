"""Before and after in one picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from vidstyle.core.picture import Picture

if TYPE_CHECKING:
    from vidstyle.media.read.reader import VideoInfo

Compare = Literal["side", "split"]
"""side: the source on the left, the result on its right; split: the left half of the one and the right half
of the other, with a white line between them."""


def compared_info(info: VideoInfo, how: Compare | None) -> VideoInfo:
    """What a film of compared pictures is like: twice as wide where they stand side by side."""
    if how != "side":
        return info
    return replace(info, width=_whole_chroma(info.width, info.encoding.step[0]) + info.width)


def compared(before: Picture, after: Picture, how: Compare) -> Picture:
    """Both pictures in one; they have the same size, encoding and kinds of planes.

    >>> black, white = np.zeros((2, 7), np.uint8), np.full((2, 7), 255, np.uint8)
    >>> compared(Picture.from_array(black), Picture.from_array(white), "side").luma[0].tolist()
    [0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255]
    """
    step = 1 if before.luma is None else before.encoding.step[0]
    width = before.shape[1]
    if how == "side":
        missing = _whole_chroma(width, step) - width
        return _beside(_widened(before, missing), after)
    middle = width // 2 // step * step
    # Thin, but still there when a 4K film is looked at in a small window.
    end = min(middle + step * max(1, width // 640 // step), width)
    line = _white(_columns(before, middle, end))
    return _beside(_columns(before, 0, middle), line, _columns(after, end, width))


def _whole_chroma(width: int, step: int) -> int:
    """The width up to the next whole chroma sample, so that both halves keep their own colours."""
    step = max(step, 2)
    return -(-width // step) * step


def _widened(picture: Picture, missing: int) -> Picture:
    def widen(plane: np.ndarray, step: int) -> np.ndarray:
        # Chroma planes end on whole samples as they are.
        return plane if step > 1 else np.concatenate([plane, *[plane[:, -1:]] * missing], axis=1)

    return _each_plane(picture, widen)


def _columns(picture: Picture, start: int, end: int) -> Picture:
    return _each_plane(picture, lambda plane, step: plane[:, start // step : -(-end // step)])


def _white(picture: Picture) -> Picture:
    encoding = picture.encoding
    top = 1.0 if encoding.depth == 0 else 2**encoding.depth - 1
    luma, neutral = encoding.luma_levels[1], encoding.chroma_levels[0]
    return replace(
        picture,
        luma=None if picture.luma is None else np.full_like(picture.luma, luma),
        chroma=picture.chroma and (np.full_like(picture.chroma[0], neutral),) * 2,
        color=None if picture.color is None else np.full_like(picture.color, top),
        alpha=None if picture.alpha is None else np.full_like(picture.alpha, top),
    )


def _each_plane(picture: Picture, change: Callable[[np.ndarray, int], np.ndarray]) -> Picture:
    """The picture with every plane changed; `change` also gets the luma pixels for each of its columns."""
    across = picture.encoding.step[0]
    chroma = picture.chroma and (change(picture.chroma[0], across), change(picture.chroma[1], across))
    whole = (
        None if plane is None else change(plane, 1) for plane in (picture.luma, picture.color, picture.alpha)
    )
    luma, color, alpha = whole
    return Picture(picture.encoding, luma=luma, chroma=chroma, color=color, alpha=alpha)


def _beside(*pictures: Picture) -> Picture:
    def join(planes: list[np.ndarray | None]) -> np.ndarray | None:
        there = [plane for plane in planes if plane is not None]
        return np.concatenate(there, axis=1) if there else None

    chromas = [picture.chroma for picture in pictures if picture.chroma]
    return Picture(
        pictures[0].encoding,
        luma=join([picture.luma for picture in pictures]),
        chroma=(
            np.concatenate([blue for blue, _ in chromas], axis=1),
            np.concatenate([red for _, red in chromas], axis=1),
        )
        if chromas
        else None,
        color=join([picture.color for picture in pictures]),
        alpha=join([picture.alpha for picture in pictures]),
    )
