"""Times equal jobs done by vidstyle and by other programs, side by side: whole processes, in pairs.

    python tools/compare_peers.py clip.mp4 [--pairs 5] [--job plain]

The peers must be installed; a job whose program is missing is named and left out. The order within a
pair alternates, so that neither side always finds the file warm. Printed: the median of each side and
the median, least and greatest ratio of the pairs.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

ENCODE = ["-c:v", "libx264", "-preset", "veryfast", "-crf", "18", "-pix_fmt", "yuv420p"]
OURS = ["--preset", "veryfast", "--crf", "18", "--progress", "none", "-y"]

Command = Callable[[Path, Path], list[str]]


def _vidstyle(style: str) -> Command:
    program = [sys.executable, "-m", "vidstyle", "render"]
    return lambda clip, out: [*program, str(clip), str(out), "--style", style, *OURS]


def _ffmpeg(*filters: str) -> Command:
    start = ["ffmpeg", "-v", "error", "-nostdin", "-y", "-i"]
    rest = [*filters, "-map", "0:v:0", "-map", "0:a?", *ENCODE, "-c:a", "copy"]
    return lambda clip, out: [*start, str(clip), *rest, str(out)]


JOBS: dict[str, tuple[Command, Command]] = {"plain": (_vidstyle("plain"), _ffmpeg())}
"""The jobs by name: our command and the peer's."""


def main() -> None:
    """Run the jobs that were asked for and print a line for each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clip", type=Path)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--job", choices=sorted(JOBS), action="append")
    options = parser.parse_args()
    for job in options.job or JOBS:
        ours, peer = JOBS[job]
        program = peer(options.clip, Path("out.mp4"))[0]
        if shutil.which(program) is None:
            print(f"{job}: {program} is not installed, left out")
        else:
            print(f"{job}: {_compare(ours, peer, options.clip, options.pairs)}")


def _compare(ours: Command, peer: Command, clip: Path, pairs: int) -> str:
    times: dict[Command, list[float]] = {ours: [], peer: []}
    with tempfile.TemporaryDirectory() as folder:
        for number in range(pairs + 1):
            for command in (ours, peer) if number % 2 else (peer, ours):
                elapsed = _time(command(clip, Path(folder) / "out.mp4"))
                if number:  # the first pair only warms up
                    times[command].append(elapsed)
    ratios = sorted(own / other for own, other in zip(times[ours], times[peer], strict=True))
    own, other = (statistics.median(times[command]) for command in (ours, peer))
    ratio = statistics.median(ratios)
    return (
        f"vidstyle {own:.2f} s, peer {other:.2f} s, ratio {ratio:.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f})"
    )


def _time(command: list[str]) -> float:
    began = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - began


if __name__ == "__main__":
    main()
