"""Frames, and conversion between FFmpeg frames and pictures without colour conversion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import InputError, not_a_picture
from vidstyle.media.color_tags import (
    FULL_RANGE,
    HDR_TRANSFERS,
    ColorTags,
    default_tags,
    matrix_from_tags,
    siting_from_codec,
)
from vidstyle.media.pixel_formats import PlaneLayout, format_name, layout_of


@dataclass(frozen=True)
class DecodedFrame:
    """A frame as the source stores it, with a repaired timestamp.

    Attributes:
        native: the decoded frame.
        pts, duration: in the time base of the source; `duration` is None if unknown.
        key: whether it is a key frame, at which decoding can start.
        repeated: whether it replaces a frame that could not be decoded.
        damaged: whether it may show damage, see `FilmSampler`; readers leave it False.
    """

    native: av.VideoFrame
    pts: int
    duration: int | None = None
    key: bool = False
    repeated: bool = False
    damaged: bool = False


@dataclass(frozen=True)
class Frame:
    """One picture of a film and its presentation time.

    Attributes:
        picture: upright; views on the decoder's memory where possible.
        pts: presentation time in `time_base` units; strictly increasing in a film.
        time_base: seconds for each unit of `pts`.
        duration: in `time_base` units, if known.
        native: the decoded frame if `picture` consists of views on its planes, else None.
        key: whether it is a key frame of the source.
    """

    picture: Picture
    pts: int
    time_base: Fraction
    duration: int | None = None
    native: av.VideoFrame | None = None
    key: bool = False

    @property
    def time(self) -> Fraction:
        """Presentation time in seconds."""
        return self.pts * self.time_base


def to_supported_format(frame: av.VideoFrame, subject: object = "frame") -> av.VideoFrame:
    """Return the frame, or the same samples in a pixel format with separate planes or packed RGB.

    Raises:
        InputError: an unsupported pixel format; `subject` names the source.
    """
    layout = _require_layout(frame, subject)
    if not layout.reordered_as:
        return frame
    # The same range on both sides: swscale would otherwise assume one and convert.
    reordered = frame.reformat(
        format=layout.reordered_as, src_color_range=FULL_RANGE, dst_color_range=FULL_RANGE
    )
    ColorTags.of(frame).put_on(reordered)
    return reordered


def picture_from_frame(
    frame: av.VideoFrame, codec: str = "", tags: ColorTags | None = None, subject: object = "frame"
) -> Picture:
    """Return the frame's planes as a picture, without row padding; as views if the layout allows.

    Args:
        frame: in any format; unsupported layouts are converted by `to_supported_format`.
        codec: name of the decoder, on which the chroma siting depends.
        tags: used instead of the frame's own.
        subject: names the source in errors.

    Raises:
        InputError: an unsupported pixel format or colour matrix.
        UsageError: no frame.
    """
    if not isinstance(frame, av.VideoFrame):
        raise not_a_picture(frame, "an av.VideoFrame or an array")
    frame = to_supported_format(frame, subject)
    layout = _require_layout(frame, subject)
    tags = tags or ColorTags.of(frame)
    encoding = _encoding(layout, tags, codec, frame, subject)
    planes = [_view_plane(plane, layout) for plane in frame.planes]
    if layout.kind == "packed":
        alpha = planes[0][..., 3] if layout.alpha else None
        return Picture(encoding, color=planes[0][..., :3], alpha=alpha)
    if layout.kind == "planar":
        import cv2

        green, blue, red = planes[:3]
        return Picture(encoding, color=cv2.merge([red, green, blue]), alpha=_alpha_plane(planes, layout))
    if layout.planes == 1 and layout.alpha:
        import cv2

        luma, alpha = cv2.split(planes[0])
        return Picture(encoding, luma=luma, alpha=alpha)
    chroma = (planes[1], planes[2]) if layout.planes == 3 else None
    return Picture(encoding, luma=planes[0], chroma=chroma, alpha=_alpha_plane(planes, layout))


def frame_from_picture(
    picture: Picture, size: tuple[int, int] | None = None, tags: ColorTags | None = None
) -> av.VideoFrame:
    """Return a new frame with a copy of the picture's planes and colour tags.

    Args:
        picture: with integer samples; the pixel format follows from its encoding.
        size: height and width of the frame; padding repeats the last row and column of the picture.
        tags: primaries, transfer, matrix and range to write; None: the usual ones of the encoding.

    Raises:
        ValueError: float samples, or FFmpeg has no format of this depth and subsampling.
    """
    encoding = picture.encoding
    if encoding.depth == 0:
        raise ValueError("float samples must be converted to integers before they become a frame")
    rgb, chroma, alpha = picture.color is not None, picture.chroma is not None, picture.alpha is not None
    name = format_name(encoding.depth, encoding.subsampling, rgb=rgb, chroma=chroma, alpha=alpha)
    height, width = size or picture.shape
    frame = av.VideoFrame(width, height, name)
    for target, plane in zip(frame.planes, _planes(picture, name), strict=True):
        _fill_plane(target, plane)
    (tags or default_tags(encoding, height)).put_on(frame)
    return frame


def _require_layout(frame: av.VideoFrame, subject: object) -> PlaneLayout:
    layout = layout_of(frame.format.name)
    if layout is None:
        raise InputError(subject, f"its pixel format {frame.format.name} is not one that vidstyle reads")
    return layout


def _encoding(
    layout: PlaneLayout, tags: ColorTags, codec: str, frame: av.VideoFrame, subject: object
) -> Encoding:
    transfer = HDR_TRANSFERS.get(tags.transfer, "sdr")
    if layout.kind != "luma":
        matrix = "bt709" if transfer == "sdr" else "bt2020"
        return Encoding(matrix, True, layout.depth, (1, 1), (0.0, 0.0), transfer)
    gray = layout.planes == 1
    full_range = layout.full_range or tags.range == FULL_RANGE or (gray and tags.range == 0)
    matrix = matrix_from_tags(subject, tags, codec, frame.height, frame.width)
    siting = siting_from_codec(codec, tags, layout.subsampling)
    return Encoding(matrix, full_range, layout.depth, layout.subsampling, siting, transfer)


def _view_memory(plane: Any, dtype: np.dtype[Any], channels: int) -> np.ndarray:
    """Return a view on the memory of a plane: H x W, or H x W x channels if several; rows may be padded."""
    pixel = channels * dtype.itemsize
    shape, strides = (plane.height, plane.width, channels), (plane.line_size, pixel, dtype.itemsize)
    dimensions = 3 if channels > 1 else 2
    first = max(0, -plane.line_size) * (plane.height - 1)
    return np.ndarray(shape[:dimensions], dtype, buffer=plane, offset=first, strides=strides[:dimensions])


def _view_plane(plane: Any, layout: PlaneLayout) -> np.ndarray:
    """Return the plane's samples as H x W, or H x W x channels for packed formats."""
    dtype = np.dtype(np.uint8 if layout.depth <= 8 else ">u2" if layout.big_endian else "<u2")
    several = layout.kind == "packed" or (layout.kind == "luma" and layout.planes == 1)
    view = _view_memory(plane, dtype, layout.planes + layout.alpha if several else 1)
    # OpenCV supports neither negative strides nor foreign byte orders: such planes are copied.
    upside_down, swapped = plane.line_size < 0, layout.big_endian and layout.depth > 8
    return view.astype(np.uint8 if layout.depth <= 8 else np.uint16) if upside_down or swapped else view


def _alpha_plane(planes: Sequence[np.ndarray], layout: PlaneLayout) -> np.ndarray | None:
    return planes[3] if layout.alpha else None


def _planes(picture: Picture, name: str) -> list[np.ndarray]:
    """Return the planes in the order of FFmpeg's format."""
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


def _fill_plane(target: Any, plane: np.ndarray) -> None:
    height, width = target.height, target.width
    plane = plane[:height, :width]
    rows = _view_memory(target, plane.dtype, 1 if plane.ndim == 2 else plane.shape[2])
    filled_height, filled_width = plane.shape[:2]
    rows[:filled_height, :filled_width] = plane
    rows[:filled_height, filled_width:] = plane[:, -1:]
    rows[filled_height:] = rows[filled_height - 1]
