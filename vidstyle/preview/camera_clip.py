"""A camera, a screen or a stream as the clip of a page."""

from __future__ import annotations

import threading

import cv2
import numpy as np

from vidstyle.core.convert import to_rgb
from vidstyle.errors import DeviceError
from vidstyle.live.capture import FIRST_FRAME_SECONDS, Capture
from vidstyle.media.audio import AudioChunk
from vidstyle.media.capture.input import LiveSource
from vidstyle.media.read.frame_converter import FrameConverter
from vidstyle.media.resize import stretch_to_square_pixels

DEFAULT_RATE = 25.0
CLOSE_SECONDS = 1.0


class CameraClip:
    """A clip that always returns the newest frame of a live source; see `Clip`."""

    live = True
    count = 1

    def __init__(self, source: LiveSource) -> None:
        """Open it and wait for its first frame.

        Raises:
            DeviceError: it is missing, or gives no frame.
        """
        self.name = self.source = source.name
        self._lock = threading.Lock()
        self._capture = Capture(source, _ignore)
        self._capture.start()
        first = self._capture.frames.get(FIRST_FRAME_SECONDS)
        if first is None:
            self.close()
            raise self._capture.error or DeviceError(
                source.name, f"has delivered no frame for {FIRST_FRAME_SECONDS:g} s"
            )
        self._newest = first.native
        self._converter = FrameConverter(
            first.native, self._capture.codec, source.name, sample_aspect=self._capture.sample_aspect
        )
        self.fps = float(self._capture.rate or DEFAULT_RATE)
        height, width = self.frame(0).shape[:2]
        self.size = width, height

    def frame(self, number: int, side: int | None = None) -> np.ndarray:
        """See `Clip`."""
        with self._lock:
            arrived = self._capture.frames.get(0)
            if arrived is not None:
                self._newest = arrived.native
            whole = to_rgb(self._converter.convert(self._newest)[0])
        whole = stretch_to_square_pixels(whole, self._converter.sample_aspect)
        return shrink(whole, side)

    def glance(self, number: int, side: int) -> np.ndarray:
        """See `Clip`; kernels are compiled when a camera is opened."""
        return self.frame(number, side)

    def file(self) -> None:
        """See `Clip`."""

    def close(self) -> None:
        """See `Clip`."""
        self._capture.close(CLOSE_SECONDS)


def shrink(picture: np.ndarray, side: int | None) -> np.ndarray:
    """Reduce an H x W x 3 picture to a shorter side of at most `side` pixels; None: keep its size."""
    height, width = picture.shape[:2]
    if side is None or side >= min(height, width):
        return picture
    factor = side / min(height, width)
    size = max(1, round(width * factor)), max(1, round(height * factor))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


def _ignore(chunk: AudioChunk) -> None:
    """Discard sound."""
