"""One picture out of a film, a photograph or a sequence, as the gallery shows it."""

from __future__ import annotations

import logging
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np

from vidstyle.core.convert import to_rgb
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader, ReadOptions, open_reader, open_source

MAX_SIDE = 960
"""Pixels; styles take seconds at this size, and show what they do."""

log = logging.getLogger("vidstyle")


def read_still(
    source: str | Path, read: ReadOptions | None = None, longest_side: int = MAX_SIDE
) -> np.ndarray:
    """One picture of the source, upright, with square pixels, reduced to the longest side: H x W x 3 uint8.

    Args:
        source: what `open_reader` opens.
        read: how to read it; without a start, the middle of a film is taken and the first picture of a pipe.
        longest_side: in pixels.

    Raises:
        InputError: it cannot be read, or has no picture at that time.
    """
    read = read or ReadOptions()
    middle = _middle(source, read) if read.start is None and str(source) != "-" else None
    if middle is not None:
        try:
            return _read(source, replace(read, start=middle), longest_side)
        except InputError:
            log.warning(
                "%s: has no picture in the middle of the time that it announces: its first is shown", source
            )
    return _read(source, read, longest_side)


def _middle(source: str | Path, read: ReadOptions) -> Fraction | None:
    """When half of a film has passed, if it is one."""
    opened = open_source(source, read)
    try:
        return opened.duration / 2 if opened.duration and opened.frames != 1 else None
    finally:
        opened.close()


def _read(source: str | Path, read: ReadOptions, longest_side: int) -> np.ndarray:
    with open_reader(source, read) as reader:
        return _still(reader, longest_side)


def _still(reader: Reader, longest_side: int) -> np.ndarray:
    frame = next(item for item in reader if isinstance(item, Frame))
    color = to_rgb(frame.picture)
    aspect = reader.info.sample_aspect or 1
    return _reduced(color, round(color.shape[1] * aspect), longest_side)


def _reduced(color: np.ndarray, width: int, longest_side: int) -> np.ndarray:
    """The picture with its pixels made square, no side longer than allowed."""
    height = color.shape[0]
    factor = min(1, longest_side / max(width, height))
    size = max(1, round(width * factor)), max(1, round(height * factor))
    smaller = size[0] <= color.shape[1] and size[1] <= height
    return cv2.resize(color, size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR)
