"""Compare the run time of programs: vidstyle and others for the same task, or vidstyle with two settings.

    python tools/compare_peers.py clip.mp4 [--rounds 5] [--job plain ...]

Each round runs every program once; every other round runs them in reverse order, so that neither side always
has a warm file cache. The Markdown table has the medians in seconds, the ratio of our time to the other time
with its minimum and maximum over the rounds, and the ratio of processor time, which is more reliable on a
busy machine. *Cores* is our processor time divided by run time times cores. Jobs whose other program needs a
second per frame use only the first frames of the clip. Jobs whose program is missing are skipped, with a
message.
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

CORE_COUNT = os.cpu_count() or 1
SHORT_FILM_FRAMES, PICTURE_COUNT = 24, 4
"""Length of the short film and number of pictures for slow programs."""
ENCODER_OPTIONS = ["-c:v", "libx264", "-preset", "veryfast", "-crf", "18", "-pix_fmt", "yuv420p"]
FILM_OPTIONS = ["--preset", "veryfast", "--crf", "18"]
LINES_STYLE = 'format = 1\nlines = [{ block = "flow_xdog" }]\n'
DOTS_STYLE = 'format = 1\nbackground = [{ block = "halftone" }]\n'

Command = tuple[str, ...]
"""Arguments; `CLIP`, `SHORT`, `PICTURES`, `OUT`, `LINES` and `DOTS` are replaced by paths."""
Spent = tuple[float, float]
"""Wall-clock time and processor time in seconds."""


def _vidstyle(style: str, *options: str, clip: str = "CLIP", out: str = "OUT.mp4") -> Command:
    words = [sys.executable, "-m", "vidstyle", "render", clip, out, "--style", style, *options]
    return (*words, *(FILM_OPTIONS if out.endswith("mp4") else ()), "--progress", "none", "-y")


def _ffmpeg(*filters: str) -> Command:
    start = ("ffmpeg", "-v", "error", "-nostdin", "-y", "-i", "CLIP")
    return (*start, *filters, "-map", "0:a?", *ENCODER_OPTIONS, "-c:a", "copy", "OUT.mp4")


def _frei0r(name: str) -> Command:
    return _ffmpeg("-vf", f"frei0r={name}")


def _opencv(look: str) -> Command:
    return sys.executable, str(Path(__file__).with_name("opencv_look.py")), look, "SHORT", "OUT.mp4"


def _gmic(*words: str) -> Command:
    return "gmic", "-v", "-1", "PICTURES", *words, "-output", "OUT.png"


UNSTEADY = "--steady", "0"
GAUSSIANS = "format=gray,split[a][b];[a]gblur=1[c];[b]gblur=1.6[d];[c][d]lut2='clip(128+8*(x-y),0,255)'"


@dataclass(frozen=True)
class Job:
    """Two commands to compare.

    Attributes:
        target: maximum ratio of our time to the other time; None: no target.
        is_difference: whether `target` is a difference in seconds instead.
    """

    name: str
    ours: Command
    other: Command
    target: float | None = None
    is_difference: bool = False


def _looks() -> Iterator[Job]:
    for look, style in (
        ("stylization", "watercolor"),
        ("pencilSketch", "sketch"),
        ("edgePreservingFilter", "cartoon"),
        ("oilPainting", "oil"),
    ):
        yield Job(f"{style} / OpenCV {look}", _vidstyle(style, *UNSTEADY, clip="SHORT"), _opencv(look), 1)
    for style, words in (
        ("cartoon", ["cartoon", "3,200,20,0.25,1.5,8"]),
        ("oil", ["kuwahara", "9"]),
        ("sketch", ["sketchbw", "1"]),
    ):
        ours = _vidstyle(style, *UNSTEADY, clip="PICTURES_PATTERN", out="OUT_%d.png")
        yield Job(f"{style} / G'MIC {words[0]}", ours, _gmic(*words), 1)


JOBS = [
    Job("plain / FFmpeg", _vidstyle("plain"), _ffmpeg("-map", "0:v:0"), 1),
    Job(
        "flow_xdog / FFmpeg gblur, gblur, lut2",
        _vidstyle("LINES", *UNSTEADY),
        _ffmpeg("-filter_complex", GAUSSIANS),
        0.9,
    ),
    Job("cartoon / frei0r cartoon", _vidstyle("cartoon", *UNSTEADY), _frei0r("cartoon"), 0.8),
    Job("comic / frei0r cartoon", _vidstyle("comic", *UNSTEADY), _frei0r("cartoon"), 1.2),
    Job("halftone / frei0r colorhalftone", _vidstyle("DOTS", *UNSTEADY), _frei0r("colorhalftone"), 1 / 8),
    Job("ink / plain", _vidstyle("ink"), _vidstyle("plain"), 2.2),
    Job("comic / plain", _vidstyle("comic"), _vidstyle("plain"), 2.6),
    Job("impressionist / plain", _vidstyle("impressionist"), _vidstyle("plain"), 4),
    Job("first frame in ink - nothing", _vidstyle("ink", "--frames", "1"), ("true",), 0.6, True),
    Job("ink, steady 0.5 - steady 0", _vidstyle("ink"), _vidstyle("ink", *UNSTEADY), 0.8, True),
    *_looks(),
]  # fmt: skip


def main() -> None:
    """Print the table of the selected jobs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clip", type=Path)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--job", choices=[job.name for job in JOBS], action="append", metavar="NAME")
    options = parser.parse_args()
    jobs = [job for job in JOBS if job.name in (options.job or [job.name]) and _is_installed(job)]
    with tempfile.TemporaryDirectory() as folder:
        paths = _prepare(options.clip.absolute(), Path(folder))
        commands = list(dict.fromkeys(command for job in jobs for command in (job.ours, job.other)))
        spent: dict[Command, list[Spent]] = {command: [] for command in commands}
        for number in range(-1, options.rounds):  # round -1 is a warm-up
            for command in commands if number % 2 else commands[::-1]:
                found = _time([_fill_in(word, paths) for word in command])
                if number >= 0:
                    spent[command].append(found)
            print(f"round {number + 1} of {options.rounds}", file=sys.stderr, flush=True)
    print("| job | ours, s | other, s | ratio | spread | processor time | cores | target |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for job in jobs:
        print(_row(job, spent[job.ours], spent[job.other]))


def _is_installed(job: Job) -> bool:
    program = job.other[0]
    if shutil.which(program) is None:
        print(f"{job.name}: {program} is not installed, skipped", file=sys.stderr)
    return shutil.which(program) is not None


def _prepare(clip: Path, folder: Path) -> dict[str, str]:
    """Write input files and return the path of each placeholder, longer names before their prefixes."""
    (folder / "lines.toml").write_text(LINES_STYLE)
    (folder / "dots.toml").write_text(DOTS_STYLE)
    start = ["ffmpeg", "-v", "error", "-nostdin", "-y", "-i", str(clip)]
    subprocess.run(
        [*start, "-frames:v", str(SHORT_FILM_FRAMES), *ENCODER_OPTIONS, folder / "short.mp4"], check=True
    )
    subprocess.run([*start, "-frames:v", str(PICTURE_COUNT), folder / "picture_%d.png"], check=True)
    return {
        "PICTURES_PATTERN": f"{folder}/picture_%d.png",
        "PICTURES": "\n".join(f"{folder}/picture_{number}.png" for number in range(1, PICTURE_COUNT + 1)),
        "CLIP": str(clip),
        "SHORT": f"{folder}/short.mp4",
        "LINES": f"{folder}/lines.toml",
        "DOTS": f"{folder}/dots.toml",
        "OUT": f"{folder}/out",
    }


def _fill_in(word: str, paths: dict[str, str]) -> str:
    name = next((name for name in paths if word.startswith(name)), "")
    return paths[name] + word.removeprefix(name) if name else word


def _time(words: Sequence[str]) -> Spent:
    began = time.perf_counter()
    split = [part for word in words for part in word.split("\n")]
    # Write bytecode in the first round: an installed program has it, too.
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
        return sorted(one - two if job.is_difference else one / two for one, two in pairs)

    clock, processor = compare(0), compare(1)
    our_median, other_median = (statistics.median(each[0] for each in spent) for spent in (ours, other))
    unit = " s" if job.is_difference else ""
    target = f"<= {job.target:.3g}{unit}" if job.target else ""
    cells = [job.name, f"{our_median:.2f}", f"{other_median:.2f}", f"{statistics.median(clock):.2f}{unit}"]
    cells += [f"{clock[0]:.2f} to {clock[-1]:.2f}", f"{statistics.median(processor):.2f}{unit}"]
    cells += [f"{statistics.median(used / (wall * CORE_COUNT) for wall, used in ours):.2f}", target]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
