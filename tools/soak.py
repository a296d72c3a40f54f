"""Renders a long film and prints what it costs in memory, threads and open files: `python tools/soak.py`.

The slope is that of a least-squares line through the samples after a warm-up, in MB per 10,000 frames.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import threading
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np

from vidstyle.media.film import write_film
from vidstyle.media.writer import WriteOptions
from vidstyle.picture import Encoding, Picture
from vidstyle.pipeline import render
from vidstyle.progress import Progress

WARM_UP = 500
"""Frames after which every buffer has been made once."""
RATE = Fraction(25)
SAMPLE_RATE = 16000


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--style", default="plain")
    parser.add_argument("--size", type=int, nargs=2, default=(192, 108), metavar=("WIDTH", "HEIGHT"))
    arguments = parser.parse_args()
    samples: list[tuple[int, int, int, int]] = []

    def sample(progress: Progress) -> None:
        files = len(os.listdir("/proc/self/fd"))
        samples.append((progress.frames, resident_bytes(), threading.active_count(), files))

    with tempfile.TemporaryDirectory() as folder:
        film, target = Path(folder, "film.mp4"), Path(folder, "restyled.mp4")
        seconds = int(arguments.frames / RATE)
        write_film(film, pictures(arguments.frames, *arguments.size), RATE, tune(seconds), SAMPLE_RATE)
        render(film, target, arguments.style, write=WriteOptions(), on_progress=sample)
    # The last one is taken when the threads are through.
    print(report(np.array([one for one in samples[:-1] if one[0] > WARM_UP])))


def report(samples: np.ndarray) -> str:
    """The slope of memory and the ranges of the rest; samples are rows of frames, bytes, threads, files."""
    frames, resident, threads, files = samples.T
    slope = np.polyfit(frames, resident, 1)[0] * 10_000 / 2**20
    return (
        f"{len(samples)} samples over {frames[-1] - frames[0]} frames: {slope:+.2f} MB per 10,000 frames "
        f"({resident.min() / 2**20:.1f} to {resident.max() / 2**20:.1f} MB), "
        f"threads {threads.min()} to {threads.max()}, open files {files.min()} to {files.max()}"
    )


def resident_bytes() -> int:
    """Memory that this process has in RAM; Linux only."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def pictures(count: int, width: int, height: int) -> Iterator[Picture]:
    """A moving ramp."""
    encoding = Encoding()
    across = np.arange(width, dtype=np.int64) + np.arange(height)[:, None]
    neutral = np.full(encoding.chroma_shape(height, width), 128, np.uint8)
    for number in range(count):
        luma = (16 + (across + 2 * number) % 200).astype(np.uint8)
        yield Picture(encoding, luma=luma, chroma=(neutral, neutral))


def tune(seconds: int) -> np.ndarray:
    """A soft tone."""
    tone: np.ndarray = np.sin(np.arange(seconds * SAMPLE_RATE, dtype=np.float32) * 0.2)
    return tone * np.float32(0.1)


if __name__ == "__main__":
    main()
