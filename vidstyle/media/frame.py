"""Frames, and conversion between FFmpeg's frames and pictures without colour conversion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import InputError, not_a_picture
from vidstyle.media.color_tags import FULL, ColorTags, default_tags, matrix_from_tags, siting_from_codec
from vidstyle.media.pixel_formats import PlaneLayout, format_name, layout_of


@dataclass(frozen=True)
class DecodedFrame:
    """A frame as the source stores it, with a repaired timestamp.

    Attributes:
        native: the decoded frame.
        pts, duration: in the time base of the source; `duration` is None where it is unknown.
        key: whether the source can be entered here (key frame).
        repeated: whether it replaces a frame that could not be decoded.
    """

    native: av.VideoFrame
    pts: int
    duration: int | None = None
    key: bool = False
    repeated: bool = False


@dataclass(frozen=True)
class Frame:
    """One picture of a film and when it is shown.

    Attributes:
        picture: upright; views on the decoder's memory where possible.
        pts: when it is shown, in `time_base` units; strictly increasing in a film.
        time_base: seconds for each unit of `pts`.
        duration: how long it is shown, in `time_base` units, if known.
        native: the decoded frame when `picture` is exactly its planes, else None. Keeping it keeps them.
        key: whether it was a key frame of the source.
    """

    picture: Picture
    pts: int
    time_base: Fraction
    duration: int | None = None
    native: av.VideoFrame | None = None
    key: bool = False

    @property
    def time(self) -> Fraction:
        """When it is shown, in seconds."""
        return self.pts * self.time_base


def to_supported_format(frame: av.VideoFrame, subject: object = "frame") -> av.VideoFrame:
    """The frame itself, or the same samples in a pixel format with separate planes or packed RGB.

    Raises:
        InputError: an unsupported pixel format; `subject` names the source.
    """
    layout = _layout(frame, subject)
    if not layout.reordered_as:
        return frame
    # The same range on both sides, whichever it is: swscale would otherwise assume one and convert.
    reordered = frame.reformat(format=layout.reordered_as, src_color_range=FULL, dst_color_range=FULL)
    ColorTags.of(frame).put_on(reordered)
    return reordered


def picture_from_frame(
    frame: av.VideoFrame, codec: str = "", tags: ColorTags | None = None, subject: object = "frame"
) -> Picture:
    """The frame's planes as a picture, row padding left out; views wherever the layout allows.

    Args:
        frame: in a layout of its own or one that `to_supported_format` has made.
        codec: name of the decoder, which the chroma siting depends on.
        tags: used instead of the frame's own.
        subject: names the source in errors.

    Raises:
        InputError: an unsupported pixel format or colour matrix.
        UsageError: no frame.
    """
    if not isinstance(frame, av.VideoFrame):
        raise not_a_picture(frame, "an av.VideoFrame or an array")
    frame = to_supported_format(frame, subject)
    layout = _layout(frame, subject)
    tags = tags or ColorTags.of(frame)
    encoding = _encoding(layout, tags, codec, frame, subject)
    planes = [_view(plane, layout) for plane in frame.planes]
    if layout.kind == "packed":
        alpha = planes[0][..., 3] if layout.alpha else None
        return Picture(encoding, color=planes[0][..., :3], alpha=alpha)
    if layout.kind == "planar":
        import cv2

        green, blue, red = planes[:3]
        return Picture(encoding, color=cv2.merge([red, green, blue]), alpha=_fourth(planes, layout))
    if layout.planes == 1 and layout.alpha:
        import cv2

        luma, alpha = cv2.split(planes[0])
        return Picture(encoding, luma=luma, alpha=alpha)
    chroma = (planes[1], planes[2]) if layout.planes == 3 else None
    return Picture(encoding, luma=planes[0], chroma=chroma, alpha=_fourth(planes, layout))


def frame_from_picture(
    picture: Picture, size: tuple[int, int] | None = None, tags: ColorTags | None = None
) -> av.VideoFrame:
    """A new frame that holds a copy of the picture's planes, tagged.

    Args:
        picture: of integers; the pixel format follows from its encoding.
        size: height and width of the frame; what the picture lacks repeats its last row and column.
        tags: primaries, transfer, matrix and range to write; None: those usual for the encoding.

    Raises:
        ValueError: float samples, or a depth and chroma step that FFmpeg has no format for.
    """
    encoding = picture.encoding
    if encoding.depth == 0:
        raise ValueError("float samples are brought to integers before they become a frame")
    rgb, chroma, alpha = picture.color is not None, picture.chroma is not None, picture.alpha is not None
    name = format_name(encoding.depth, encoding.step, rgb=rgb, chroma=chroma, alpha=alpha)
    height, width = size or picture.shape
    frame = av.VideoFrame(width, height, name)
    for target, plane in zip(frame.planes, _planes(picture, name), strict=True):
        _write(target, plane)
    (tags or default_tags(encoding, height)).put_on(frame)
    return frame


def _layout(frame: av.VideoFrame, subject: object) -> PlaneLayout:
    layout = layout_of(frame.format.name)
    if layout is None:
        raise InputError(subject, f"its pixel format {frame.format.name} is not one that vidstyle reads")
    return layout


def _encoding(
    layout: PlaneLayout, tags: ColorTags, codec: str, frame: av.VideoFrame, subject: object
) -> Encoding:
    if layout.kind != "luma":
        return Encoding("bt709", full_range=True, depth=layout.depth, step=(1, 1), siting=(0.0, 0.0))
    gray = layout.planes == 1
    full_range = layout.full_range or tags.range == FULL or (gray and tags.range == 0)
    matrix = matrix_from_tags(subject, tags, codec, frame.height, frame.width)
    siting = siting_from_codec(codec, tags, layout.step)
    return Encoding(matrix, full_range, layout.depth, layout.step, siting)


def _samples(plane: Any, dtype: np.dtype[Any], channels: int) -> np.ndarray:
    """A view on the memory of a plane: H x W, or H x W x channels for several; rows may lie apart."""
    pixel = channels * dtype.itemsize
    shape, strides = (plane.height, plane.width, channels), (plane.line_size, pixel, dtype.itemsize)
    dimensions = 3 if channels > 1 else 2
    first = max(0, -plane.line_size) * (plane.height - 1)
    return np.ndarray(shape[:dimensions], dtype, buffer=plane, offset=first, strides=strides[:dimensions])


def _view(plane: Any, layout: PlaneLayout) -> np.ndarray:
    """The plane's samples as H x W, or H x W x channels for packed formats."""
    dtype = np.dtype(np.uint8 if layout.depth <= 8 else ">u2" if layout.big_endian else "<u2")
    several = layout.kind == "packed" or (layout.kind == "luma" and layout.planes == 1)
    view = _samples(plane, dtype, layout.planes + layout.alpha if several else 1)
    # OpenCV reads neither negative strides nor foreign byte orders: those are copied.
    upside_down, swapped = plane.line_size < 0, layout.big_endian and layout.depth > 8
    return view.astype(np.uint8 if layout.depth <= 8 else np.uint16) if upside_down or swapped else view


def _fourth(planes: Sequence[np.ndarray], layout: PlaneLayout) -> np.ndarray | None:
    return planes[3] if layout.alpha else None


def _planes(picture: Picture, name: str) -> list[np.ndarray]:
    """The planes in the order that FFmpeg's format has them."""
    import cv2

    alpha = [] if picture.alpha is None else [picture.alpha]
    if picture.color is not None:
        if name.startswith("gbr"):
            red, green, blue = (picture.color[..., channel] for channel in range(3))
            return [green, blue, red, *alpha]
        return [cv2.merge([*cv2.split(picture.color), *alpha])] if alpha else [picture.color]
    assert picture.luma is not None
    if picture.chroma is None:
        return [cv2.merge([picture.luma, *alpha])] if alpha else [picture.luma]
    return [picture.luma, *picture.chroma, *alpha]


def _write(target: Any, plane: np.ndarray) -> None:
    height, width = target.height, target.width
    plane = plane[:height, :width]
    rows = _samples(target, plane.dtype, 1 if plane.ndim == 2 else plane.shape[2])
    filled_height, filled_width = plane.shape[:2]
    rows[:filled_height, :filled_width] = plane
    rows[:filled_height, filled_width:] = plane[:, -1:]
    rows[filled_height:] = rows[filled_height - 1]
