"""Render a long film, and fail if memory, threads or open files grow, or if sound and picture drift apart.

`python tools/soak.py --frames 108000 --rate 10 --size 64 48` renders three hours.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.media.write.memory import write_film
from vidstyle.pipeline import stages
from vidstyle.pipeline.progress import Progress
from vidstyle.pipeline.render import render

WARM_UP_FRAMES = 500
"""Frames at the start that are not measured, while buffers are allocated."""
LAST_FRAMES = 100
"""Frames at the end that are not measured, as the reading thread may have finished."""
MIN_SAMPLES = 10
"""Minimum number of samples for a reliable slope."""
SAMPLE_SECONDS = 0.002
"""Interval of progress reports; a fast machine renders hundreds of small frames in 0.1 s."""
MAX_GROWTH_RATE = 1.0
"""Maximum memory growth in MB per 10,000 frames; in shorter runs the allocator causes larger slopes."""


def main() -> None:
    """Render a generated film, and exit with 1 if memory, threads or open files grow."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--rate", type=int, default=75, help="frames per second")
    parser.add_argument("--style", default="plain")
    parser.add_argument("--size", type=int, nargs=2, default=(192, 108), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument(
        "--kind", default="mkv", help="container of the output; FFmpeg keeps the index of an MP4 in memory"
    )
    parser.add_argument(
        "--limit", type=float, default=MAX_GROWTH_RATE, help="maximum memory growth in MB per 10,000 frames"
    )
    arguments = parser.parse_args()
    size, rate = tuple(arguments.size), arguments.rate
    stages.WATCH_SECONDS = SAMPLE_SECONDS
    samples, end_difference = soak(arguments.frames, arguments.style, size, arguments.kind, rate)
    if len(samples) < MIN_SAMPLES:
        sys.exit(f"{len(samples)} samples are too few; render more --frames")
    _, resident, threads, files = samples.T
    slope = fit_growth(samples)
    print(
        f"{len(samples)} samples: {slope:+.2f} MB per 10,000 frames "
        f"({resident.min() / 2**20:.1f} to {resident.max() / 2**20:.1f} MB), "
        f"threads {threads.min()} to {threads.max()}, open files {files.min()} to {files.max()}, "
        f"ends of the streams within {end_difference:.3f} s"
    )
    constant = threads.min() == threads.max() and files.min() == files.max()
    sys.exit(slope > arguments.limit or not constant or end_difference > 1 / rate)


def soak(frames: int, style: str, size: tuple[int, int], kind: str, rate: int) -> tuple[np.ndarray, float]:
    """Render a film and sample its use of resources.

    Returns:
        Rows of written frames, bytes of memory, threads and open files; and the maximum difference in seconds
        between the ends of a stream in the source and in the result.
    """
    samples: list[tuple[int, int, int, int]] = []

    def sample(progress: Progress) -> None:
        files = len(os.listdir("/proc/self/fd"))
        samples.append((progress.frames, resident_bytes(), threading.active_count(), files))

    with tempfile.TemporaryDirectory() as folder:
        film, target = Path(folder, "film.mp4"), Path(folder, f"restyled.{kind}")
        write_film(film, make_pictures(frames, *size), Fraction(rate), SineTone())
        render(film, target, style, on_progress=sample)
        end_difference = max(
            abs(one - other) for one, other in zip(stream_ends(film), stream_ends(target), strict=True)
        )
    return np.array(
        [one for one in samples if WARM_UP_FRAMES < one[0] < frames - LAST_FRAMES]
    ), end_difference


def stream_ends(path: Path) -> list[float]:
    """Return the end of each stream in seconds."""
    with av.open(str(path)) as container:
        last = [0.0] * len(container.streams)
        for packet in container.demux():
            if packet.pts is not None and packet.time_base is not None:
                end = float((packet.pts + (packet.duration or 0)) * packet.time_base)
                last[packet.stream_index] = max(last[packet.stream_index], end)
    return last


def fit_growth(samples: np.ndarray) -> float:
    """Return the memory growth in MB per 10,000 frames, by a least-squares fit."""
    return float(np.polyfit(samples[:, 0], samples[:, 1], 1)[0]) * 10_000 / 2**20


def resident_bytes() -> int:
    """Return the resident memory of this process in bytes; Linux only."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def make_pictures(count: int, width: int, height: int) -> Iterator[Picture]:
    """Yield pictures of a moving ramp."""
    encoding = Encoding()
    across = np.arange(width, dtype=np.int64) + np.arange(height)[:, None]
    neutral = np.full(encoding.chroma_shape(height, width), 128, np.uint8)
    for number in range(count):
        luma = (16 + (across + 2 * number) % 200).astype(np.uint8)
        yield Picture(encoding, luma=luma, chroma=(neutral, neutral))


class SineTone:
    """An endless quiet sine tone; slices are samples."""

    def __getitem__(self, part: slice) -> np.ndarray:
        samples = np.arange(part.start, part.stop) % 100
        return (0.1 * np.sin(samples * np.pi / 50)).astype(np.float32)


if __name__ == "__main__":
    main()
