"""Kills renders at random times and plays what is left of each: `python tools/kill_test.py --times 20`.

A killed render may miss the last 2 seconds of the film that it had reached, no more.
"""

from __future__ import annotations

import argparse
import json
import random
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from vidstyle.demo.make_demo import make_film
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader, open_reader

MAY_MISS_SECONDS = 2.0


def main() -> None:
    """Kill renders, and fail if one misses more than it may."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--repeats", type=int, default=6, help="length of the film, in fours of seconds")
    parser.add_argument("--film", type=Path, help="film to render, instead of one that is made")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--within", type=float, default=4.0, help="kill at most so many seconds after the start"
    )
    parser.add_argument("--options", default="--style plain --size 1280x720", help="for vidstyle render")
    arguments = parser.parse_args()
    delays = random.Random(arguments.seed)
    good = 0
    with tempfile.TemporaryDirectory() as folder:
        film = arguments.film or Path(folder, "film.mp4")
        if not arguments.film:
            make_film(film, repeats=arguments.repeats)
        for number in range(arguments.times):
            target = Path(folder, f"killed-{number}.mp4")
            reached = kill_render(
                film, target, arguments.options.split(), delays.uniform(0, arguments.within)
            )
            left = seconds_left(target)
            good += reached - left <= MAY_MISS_SECONDS
            print(f"killed at {reached:.2f} s of the film: {left:.2f} s play")
    print(f"{good} of {arguments.times} miss at most {MAY_MISS_SECONDS:g} s")
    sys.exit(good < arguments.times)


def kill_render(film: Path, target: Path, options: list[str], delay: float) -> float:
    """Start a render and kill it `delay` seconds after its first frame; how far it had come, in seconds."""
    command = [
        sys.executable,
        "-m",
        "vidstyle",
        "render",
        str(film),
        str(target),
        "--progress",
        "json",
        *options,
    ]
    lines: list[str] = []
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        listener = threading.Thread(target=lambda: lines.extend(process.stderr or ()))
        listener.start()
        while process.poll() is None and not any(_position(line) for line in lines):
            time.sleep(0.01)
        time.sleep(delay)
        process.kill()
        listener.join()
    return max((_position(line) for line in lines), default=0.0)


def seconds_left(target: Path) -> float:
    """How long the film plays that the render has left, finished or not."""
    left = [target, *target.parent.glob(f"{target.stem}.partial*")]
    film = next((path for path in left if path.exists()), None)
    if film is None:
        return 0.0
    try:
        with open_reader(film) as reader:
            ends = [frame.time + (frame.duration or 0) * frame.time_base for frame in frames(reader)]
    except InputError:
        return 0.0
    return float(max(ends))


def frames(reader: Reader) -> list[Frame]:
    """All its frames."""
    return [item for item in reader if isinstance(item, Frame)]


def _position(line: str) -> float:
    """The film's time in a line of progress; 0 in any other line."""
    return float(json.loads(line)["position"]) if line.startswith("{") else 0.0


if __name__ == "__main__":
    main()
