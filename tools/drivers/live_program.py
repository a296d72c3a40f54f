"""Run the program in trials on real drivers, and write and read virtual cameras."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import numpy as np
from av import VideoStream

TIMEOUT_SECONDS = 120.0
"""Timeout in seconds; an emulated machine is slow."""
PICTURE_SIZE = (320, 180)
FRAME_RATE = 10
"""Frames per second."""
PIX_FMTS = {"rawvideo": "yuyv422", "mjpeg": "yuvj422p"}
DARK_LEVEL, BRIGHT_LEVEL, CHROMA_LEVELS = 30, 220, (110, 150)
"""Luma, and chroma (Cb, Cr), of the pictures written to a virtual camera."""
FLASH_SECONDS = 0.35
"""Duration of a flash in seconds: a few pictures, of which one may be lost."""


class Program:
    """`vidstyle live` while it runs."""

    def __init__(self, *arguments: str) -> None:
        self._process = subprocess.Popen(command(*arguments), stderr=subprocess.PIPE, text=True)
        self.lines: list[str] = []
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self.lines.append(line.strip())

    @property
    def has_ended(self) -> bool:
        """Whether the process has ended."""
        return self._process.poll() is not None

    def expect(self, words: str) -> None:
        """Wait until a line of its output contains these words."""
        deadline = time.monotonic() + TIMEOUT_SECONDS
        while not any(words in line for line in self.lines):
            assert time.monotonic() < deadline and not self.has_ended, f"{words!r} was not said: {self.lines}"
            time.sleep(0.02)

    def expect_file(self, path: Path) -> None:
        """Wait until the program writes a video to this path."""
        deadline = time.monotonic() + TIMEOUT_SECONDS
        while not any(each.stat().st_size for each in path.parent.glob(f"{path.stem}.partial.*")):
            assert time.monotonic() < deadline and not self.has_ended, f"{path} is not begun: {self.lines}"
            time.sleep(0.05)

    def end(self) -> None:
        """Terminate the program if it has not ended."""
        self._process.terminate()
        self._process.wait(TIMEOUT_SECONDS)
        self._thread.join(TIMEOUT_SECONDS)


@contextmanager
def run_live(*arguments: str) -> Iterator[Program]:
    """Run the program within the block."""
    program = Program(*arguments, *size_options())
    try:
        yield program
    finally:
        program.end()


def run_to_end(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the program until it ends."""
    return subprocess.run(command(*arguments), capture_output=True, text=True, timeout=TIMEOUT_SECONDS)


def command(*arguments: str) -> list[str]:
    """Return the command line."""
    return [sys.executable, "-m", "vidstyle", "live", *arguments, "--no-keys", "--device", "cpu"]


def size_options() -> list[str]:
    """Return options for small pictures, for slow emulated machines."""
    return ["--size", "{}x{}".format(*PICTURE_SIZE), "--fps", str(FRAME_RATE)]


def wait_for_picture(path: str, program: Program) -> None:
    """Wait until a virtual camera shows something."""
    deadline = time.monotonic() + TIMEOUT_SECONDS
    while True:
        assert time.monotonic() < deadline and not program.has_ended, f"no frame is written: {program.lines}"
        try:
            column_colors(path)
            return
        except (av.FFmpegError, OSError):
            time.sleep(0.3)


def column_colors(path: str) -> np.ndarray:
    """Return the median colour of eight columns of a camera's picture, below its text: 8 x 3, 0..255."""
    with av.open(path, format="v4l2", options={"video_size": "{}x{}".format(*PICTURE_SIZE)}) as container:
        frames = container.decode(video=0)
        for _ in range(3):
            frame = next(frames)
        picture = frame.to_ndarray(format="rgb24", src_colorspace="ITU601").astype(float)
    lower = picture[picture.shape[0] * 2 // 3 :]
    middle = [lower[:, int(place * lower.shape[1])] for place in (np.arange(8) + 0.5) / 8]
    return np.array([np.median(column, axis=0) for column in middle])


class FlashWriter:
    """Writes dark pictures to a virtual camera, and some bright ones on demand.

    Args:
        path: device of the camera.
        codec: "rawvideo" or "mjpeg".

    Attributes:
        began: time of the first picture, in seconds of `time.monotonic`.
        flashed: time of the first bright picture.
    """

    def __init__(self, path: str, codec: str = "rawvideo") -> None:
        self.began = self.flashed = 0.0
        self._flash = float("inf")
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._write, args=(path, codec), daemon=True)
        self._thread.start()
        while not self.began and self._thread.is_alive():
            time.sleep(0.01)

    def flash(self, moment: float) -> None:
        """Write bright pictures from this time on, for `FLASH_SECONDS`."""
        self._flash = moment

    def end(self) -> None:
        """Close the camera."""
        self._over.set()
        self._thread.join(TIMEOUT_SECONDS)

    def _write(self, path: str, codec: str) -> None:
        pix_fmt = PIX_FMTS[codec]
        dark, bright = (_even_picture(level, pix_fmt) for level in (DARK_LEVEL, BRIGHT_LEVEL))
        with av.open(path, "w", "v4l2") as container:
            stream = cast(VideoStream, container.add_stream(codec, rate=FRAME_RATE))
            stream.width, stream.height, stream.pix_fmt = *PICTURE_SIZE, pix_fmt
            stream.codec_context.time_base = Fraction(1, FRAME_RATE)
            number = 0
            while not self._over.wait(min(1 / FRAME_RATE, max(0.0, self._flash - time.monotonic()))):
                due = time.monotonic() >= self._flash
                frame = bright if due or time.monotonic() - self.flashed < FLASH_SECONDS else dark
                frame.pts, number = number, number + 1
                container.mux(stream.encode(frame))
                self.began = self.began or time.monotonic()
                if due:
                    self.flashed, self._flash = time.monotonic(), float("inf")


def _even_picture(level: int, pix_fmt: str) -> av.VideoFrame:
    frame = av.VideoFrame(*PICTURE_SIZE, pix_fmt)
    samples = [[level], [CHROMA_LEVELS[0]], [CHROMA_LEVELS[1]]]
    if len(frame.planes) == 1:
        samples = [[level, CHROMA_LEVELS[0], level, CHROMA_LEVELS[1]]]
    for plane, pattern in zip(frame.planes, samples, strict=True):
        plane.update(bytes(pattern * (plane.buffer_size // len(pattern))))
    return frame
