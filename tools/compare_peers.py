"""Times whole programs side by side: vidstyle and others that do the same, or vidstyle at two settings.

    python tools/compare_peers.py clip.mp4 [--rounds 5] [--job plain ...]

Each round runs every program once, every other round in the opposite order, so that both sides of a job run
under like conditions and neither always finds the file warm. Printed is a Markdown table: medians in seconds,
then the ratio of our time to the other's, least and greatest of the rounds, and the ratio of processor time,
which says more on a machine that does something else. *Cores* is our processor time divided by that of all
cores while it ran: what is missing from 1 was idle, or taken by others. Looks that take others a second a
frame have the first frames of the clip alone. A job whose program is missing is named and left out.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

CORES = os.cpu_count() or 1
SHORT, PICTURES = 24, 4
"""Frames of the films, and pictures, of which slow programs make a look."""
ENCODE = ["-c:v", "libx264", "-preset", "veryfast", "-crf", "18", "-pix_fmt", "yuv420p"]
FILM = ["--preset", "veryfast", "--crf", "18"]
LINES = 'format = 1\nlines = [{ block = "flow_xdog" }]\n'
DOTS = 'format = 1\nbackground = [{ block = "halftone" }]\n'

Command = tuple[str, ...]
"""Words, in which `CLIP`, `SHORT`, `PICTURES`, `OUT`, `LINES` and `DOTS` stand for paths."""
Spent = tuple[float, float]
"""Seconds by the clock, and of processor time."""


def _vidstyle(style: str, *options: str, clip: str = "CLIP", out: str = "OUT.mp4") -> Command:
    words = [sys.executable, "-m", "vidstyle", "render", clip, out, "--style", style, *options]
    return (*words, *(FILM if out.endswith("mp4") else ()), "--progress", "none", "-y")


def _ffmpeg(*filters: str) -> Command:
    start = ("ffmpeg", "-v", "error", "-nostdin", "-y", "-i", "CLIP")
    return (*start, *filters, "-map", "0:a?", *ENCODE, "-c:a", "copy", "OUT.mp4")


def _frei0r(name: str) -> Command:
    return _ffmpeg("-vf", f"frei0r={name}")


def _opencv(look: str) -> Command:
    return sys.executable, str(Path(__file__).with_name("opencv_look.py")), look, "SHORT", "OUT.mp4"


def _gmic(*words: str) -> Command:
    return "gmic", "-v", "-1", "PICTURES", *words, "-output", "OUT.png"


STILL = "--steady", "0"
GAUSSIANS = "format=gray,split[a][b];[a]gblur=1[c];[b]gblur=1.6[d];[c][d]lut2='clip(128+8*(x-y),0,255)'"


@dataclass(frozen=True)
class Job:
    """Two commands.

    Attributes:
        wanted: the greatest ratio of our time to the other's; None: only shown.
        seconds: whether `wanted` is a difference in seconds instead.
    """

    name: str
    ours: Command
    other: Command
    wanted: float | None = None
    seconds: bool = False


def _looks() -> Iterator[Job]:
    for look, style in (
        ("stylization", "watercolor"),
        ("pencilSketch", "sketch"),
        ("edgePreservingFilter", "cartoon"),
        ("oilPainting", "oil"),
    ):
        yield Job(f"{style} / OpenCV {look}", _vidstyle(style, *STILL, clip="SHORT"), _opencv(look), 1)
    for style, words in (
        ("cartoon", ["cartoon", "3,200,20,0.25,1.5,8"]),
        ("oil", ["kuwahara", "9"]),
        ("sketch", ["sketchbw", "1"]),
    ):
        ours = _vidstyle(style, *STILL, clip="PICTURES_PATTERN", out="OUT_%d.png")
        yield Job(f"{style} / G'MIC {words[0]}", ours, _gmic(*words), 1)


JOBS = [
    Job("plain / FFmpeg", _vidstyle("plain"), _ffmpeg("-map", "0:v:0"), 1),
    Job(
        "flow_xdog / FFmpeg gblur, gblur, lut2",
        _vidstyle("LINES", *STILL),
        _ffmpeg("-filter_complex", GAUSSIANS),
        0.9,
    ),
    Job("cartoon / frei0r cartoon", _vidstyle("cartoon", *STILL), _frei0r("cartoon"), 0.8),
    Job("comic / frei0r cartoon", _vidstyle("comic", *STILL), _frei0r("cartoon"), 1.2),
    Job("halftone / frei0r colorhalftone", _vidstyle("DOTS", *STILL), _frei0r("colorhalftone"), 1 / 8),
    Job("ink / plain", _vidstyle("ink"), _vidstyle("plain"), 2.2),
    Job("comic / plain", _vidstyle("comic"), _vidstyle("plain"), 2.6),
    Job("impressionist / plain", _vidstyle("impressionist"), _vidstyle("plain"), 4),
    Job("first frame in ink - nothing", _vidstyle("ink", "--frames", "1"), ("true",), 0.6, seconds=True),
    Job("ink, steady 0.5 - steady 0", _vidstyle("ink"), _vidstyle("ink", *STILL), 0.8, seconds=True),
    *_looks(),
]  # fmt: skip


def main() -> None:
    """Print the table of the jobs that were asked for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clip", type=Path)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--job", choices=[job.name for job in JOBS], action="append", metavar="NAME")
    options = parser.parse_args()
    jobs = [job for job in JOBS if job.name in (options.job or [job.name]) and _is_there(job)]
    with tempfile.TemporaryDirectory() as folder:
        paths = _prepared(options.clip.absolute(), Path(folder))
        commands = list(dict.fromkeys(command for job in jobs for command in (job.ours, job.other)))
        spent: dict[Command, list[Spent]] = {command: [] for command in commands}
        for number in range(-1, options.rounds):  # the first round only warms up
            for command in commands if number % 2 else commands[::-1]:
                found = _time([_filled(word, paths) for word in command])
                if number >= 0:
                    spent[command].append(found)
            print(f"round {number + 1} of {options.rounds}", file=sys.stderr, flush=True)
    print("| job | ours, s | other, s | ratio | spread | processor time | cores | wanted |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for job in jobs:
        print(_row(job, spent[job.ours], spent[job.other]))


def _is_there(job: Job) -> bool:
    program = job.other[0]
    if shutil.which(program) is None:
        print(f"{job.name}: {program} is not installed, left out", file=sys.stderr)
    return shutil.which(program) is not None


def _prepared(clip: Path, folder: Path) -> dict[str, str]:
    """What the words in capitals stand for; longest first, as some begin alike."""
    (folder / "lines.toml").write_text(LINES)
    (folder / "dots.toml").write_text(DOTS)
    start = ["ffmpeg", "-v", "error", "-nostdin", "-y", "-i", str(clip)]
    subprocess.run([*start, "-frames:v", str(SHORT), *ENCODE, folder / "short.mp4"], check=True)
    subprocess.run([*start, "-frames:v", str(PICTURES), folder / "picture_%d.png"], check=True)
    return {
        "PICTURES_PATTERN": f"{folder}/picture_%d.png",
        "PICTURES": "\n".join(f"{folder}/picture_{number}.png" for number in range(1, PICTURES + 1)),
        "CLIP": str(clip),
        "SHORT": f"{folder}/short.mp4",
        "LINES": f"{folder}/lines.toml",
        "DOTS": f"{folder}/dots.toml",
        "OUT": f"{folder}/out",
    }


def _filled(word: str, paths: dict[str, str]) -> str:
    name = next((name for name in paths if word.startswith(name)), "")
    return paths[name] + word.removeprefix(name) if name else word


def _time(words: Sequence[str]) -> Spent:
    began = time.perf_counter()
    split = [part for word in words for part in word.split("\n")]
    # As an installed program has its bytecode: written in the first round, wherever it is.
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    process = subprocess.Popen(split, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment)
    assert process.stderr
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{' '.join(split)}: {errors.decode()}")
    return time.perf_counter() - began, usage.ru_utime + usage.ru_stime


def _row(job: Job, ours: Sequence[Spent], other: Sequence[Spent]) -> str:
    def compare(kind: int) -> list[float]:
        pairs = ((one[kind], two[kind]) for one, two in zip(ours, other, strict=True))
        return sorted(one - two if job.seconds else one / two for one, two in pairs)

    clock, processor = compare(0), compare(1)
    own, its = (statistics.median(each[0] for each in spent) for spent in (ours, other))
    unit = " s" if job.seconds else ""
    wanted = f"<= {job.wanted:.3g}{unit}" if job.wanted else ""
    cells = [job.name, f"{own:.2f}", f"{its:.2f}", f"{statistics.median(clock):.2f}{unit}"]
    cells += [f"{clock[0]:.2f} to {clock[-1]:.2f}", f"{statistics.median(processor):.2f}{unit}"]
    cells += [f"{statistics.median(used / (wall * CORES) for wall, used in ours):.2f}", wanted]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
