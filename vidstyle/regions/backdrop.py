"""A picture or a film that is shown behind people."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from vidstyle.core.closing import Closing
from vidstyle.core.convert import to_rgb
from vidstyle.core.picture import Picture
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import open_reader
from vidstyle.media.resize import resize_picture


class Backdrop(Closing):
    """Shows a picture, or a film again and again, in pictures of any size.

    Args:
        path: a picture or a film.

    Raises:
        InputError: it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._asked = 0.0
        self._cut: tuple[Frame, np.ndarray] | None = None
        self._open(0.0)

    def close(self) -> None:
        """Close the file."""
        self._reader.close()

    def at(self, time: float | None, shape: tuple[int, int]) -> np.ndarray:
        """Return the picture for a time in seconds, cut to a shape: H x W x 3 uint8 RGB.

        After a jump back in time, and without a time, the film begins again.
        """
        time = 0.0 if time is None else time
        if time < self._asked:
            self._reader.close()
            self._open(0.0)
        self._asked = time
        while time >= self._end:
            self._advance()
        if self._cut is None or self._cut[0] is not self._shown or self._cut[1].shape[:2] != shape:
            self._cut = self._shown, _cover(self._shown.picture, shape)
        return self._cut[1]

    def _open(self, begin: float) -> None:
        """Begin the film at a time in seconds."""
        self._reader = open_reader(self._path)
        self._frames = (item for item in self._reader if isinstance(item, Frame))
        self._shown, self._next = next(self._frames), next(self._frames, None)
        self._offset = begin - float(self._shown.time)
        self._end = math.inf if self._next is None else self._offset + float(self._next.time)

    def _advance(self) -> None:
        """Show the next frame; after the last one, which lasts as long as the one before, begin again."""
        if self._next is None:
            self._reader.close()
            self._open(self._end)
            return
        length = float(self._next.time - self._shown.time)
        self._shown, self._next = self._next, next(self._frames, None)
        end = self._shown if self._next is None else self._next
        self._end = self._offset + float(end.time) + (length if self._next is None else 0.0)


def _cover(picture: Picture, shape: tuple[int, int]) -> np.ndarray:
    """Return the middle of a picture, scaled so that it fills a shape: H x W x 3 uint8 RGB."""
    (old_height, old_width), (height, width) = picture.shape, shape
    scale = max(height / old_height, width / old_width)
    high, wide = max(height, math.ceil(old_height * scale)), max(width, math.ceil(old_width * scale))
    top, left = (high - height) // 2, (wide - width) // 2
    color = to_rgb(resize_picture(picture, wide, high))
    return np.ascontiguousarray(color[top : top + height, left : left + width])
