"""Renders a long film and fails if memory, threads or open files grow, or sound and pictures part.

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

WARM_UP = 500
"""Frames after which every buffer has been made once."""
END = 100
"""Frames before the end from which on the reading thread may be through."""
MIN_SAMPLES = 10
"""Fewer tell no slope."""
SAMPLE_SECONDS = 0.002
"""How often progress is told: a quick machine is through with hundreds of small frames in 0.1 s."""
MAX_MEGABYTES = 1.0
"""Memory growth in 10,000 frames at most; steps of the allocator count for more in shorter runs."""


def main() -> None:
    """Make a film, render it, and fail if memory, threads or files grow."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--rate", type=int, default=75, help="frames per second")
    parser.add_argument("--style", default="plain")
    parser.add_argument("--size", type=int, nargs=2, default=(192, 108), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument(
        "--kind", default="mkv", help="of the output; FFmpeg holds the index of an MP4 in memory"
    )
    parser.add_argument(
        "--limit", type=float, default=MAX_MEGABYTES, help="MB that memory may grow in 10,000 frames"
    )
    arguments = parser.parse_args()
    size, rate = tuple(arguments.size), arguments.rate
    stages.WATCH_SECONDS = SAMPLE_SECONDS
    samples, apart = soak(arguments.frames, arguments.style, size, arguments.kind, rate)
    if len(samples) < MIN_SAMPLES:
        sys.exit(f"{len(samples)} samples are too few; render more --frames")
    _, resident, threads, files = samples.T
    slope = growth(samples)
    print(
        f"{len(samples)} samples: {slope:+.2f} MB per 10,000 frames "
        f"({resident.min() / 2**20:.1f} to {resident.max() / 2**20:.1f} MB), "
        f"threads {threads.min()} to {threads.max()}, open files {files.min()} to {files.max()}, "
        f"ends of the streams within {apart:.3f} s"
    )
    constant = threads.min() == threads.max() and files.min() == files.max()
    sys.exit(slope > arguments.limit or not constant or apart > 1 / rate)


def soak(frames: int, style: str, size: tuple[int, int], kind: str, rate: int) -> tuple[np.ndarray, float]:
    """What rendering costs while it goes on, and how well the streams keep together.

    Returns:
        Rows of frames written, bytes of memory, threads, open files; and by how many seconds a stream of the
        result ends before or after it did in the source, at most.
    """
    samples: list[tuple[int, int, int, int]] = []

    def sample(progress: Progress) -> None:
        files = len(os.listdir("/proc/self/fd"))
        samples.append((progress.frames, resident_bytes(), threading.active_count(), files))

    with tempfile.TemporaryDirectory() as folder:
        film, target = Path(folder, "film.mp4"), Path(folder, f"restyled.{kind}")
        write_film(film, pictures(frames, *size), Fraction(rate), Tone())
        render(film, target, style, on_progress=sample)
        apart = max(abs(one - other) for one, other in zip(ends(film), ends(target), strict=True))
    return np.array([one for one in samples if WARM_UP < one[0] < frames - END]), apart


def ends(path: Path) -> list[float]:
    """When each stream ends, in seconds."""
    with av.open(str(path)) as container:
        last = [0.0] * len(container.streams)
        for packet in container.demux():
            if packet.pts is not None and packet.time_base is not None:
                end = float((packet.pts + (packet.duration or 0)) * packet.time_base)
                last[packet.stream_index] = max(last[packet.stream_index], end)
    return last


def growth(samples: np.ndarray) -> float:
    """The slope of a least-squares line through memory, in MB per 10,000 frames."""
    return float(np.polyfit(samples[:, 0], samples[:, 1], 1)[0]) * 10_000 / 2**20


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


class Tone:
    """A soft tone without end."""

    def __getitem__(self, part: slice) -> np.ndarray:
        samples = np.arange(part.start, part.stop) % 100
        return (0.1 * np.sin(samples * np.pi / 50)).astype(np.float32)


if __name__ == "__main__":
    main()
