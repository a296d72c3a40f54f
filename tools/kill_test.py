"""Kill renders at random times and resume them, and let two renders write the same file.

    python tools/kill_test.py --times 100 --endings .mp4 .mkv .mov --styles plain ink comic --resume 20

A killed render may lose at most the last 2 seconds before its position. A resumed film has the frame times of
an uninterrupted render, equal pictures from the first cut after the resume point on, and pictures within one
code value before it.

    python tools/kill_test.py --times 0 --pairs 200

Two renders write the same file, started at random times and with or without -y. At least one succeeds, the
file belongs to one that succeeded, and no other files remain.

    python tools/kill_test.py --times 0 --neighbors 100

Renders, a third of them killed and resumed, run in a folder with other files that have the names of temporary
files of this or earlier versions. These files must not change; a conflicting file must be refused.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import shlex
import shutil
import sys
import tempfile
import time
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle import cli
from vidstyle.core.sampling import small_luma
from vidstyle.core.scene_cuts import SceneCutDetector
from vidstyle.demo.make_demo import make_film
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader, open_reader

MAX_LOST_SECONDS = 2.0
LOSSLESS = ("--codec", "libx264", "--crf", "0")
PAIR_FRAME_COUNTS = {(96, 54): 20, (80, 46): 26}
"""Frame size and number of frames of the two renders, which identify the owner of the file."""


def main() -> None:
    """Run the tests, and exit with 1 if a film is wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--resume", type=int, default=0, help="number of killed renders to resume")
    parser.add_argument("--pairs", type=int, default=0, help="number of pairs of renders to the same file")
    parser.add_argument("--neighbors", type=int, default=0, help="number of renders among files of others")
    parser.add_argument("--repeats", type=int, default=6, help="length of the film in units of 4 seconds")
    parser.add_argument("--film", type=Path, help="film to render; default: generated")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--within", type=float, default=20.0, help="kill within the first N seconds of the film"
    )
    parser.add_argument("--endings", nargs="+", default=[".mp4"])
    parser.add_argument("--styles", nargs="+", default=["plain"])
    parser.add_argument("--options", default="--size 1280x720", help="options of vidstyle render")
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        film = arguments.film or folder / "film.mp4"
        if not arguments.film:
            make_film(film, repeats=arguments.repeats)
        options = shlex.split(arguments.options)
        bad = kill_renders(film, folder, arguments, options, rng) + run_pairs(
            film, folder, arguments.pairs, rng
        )
        bad += run_among_neighbors(film, folder, arguments.neighbors, rng)
    sys.exit(bad > 0)


PROCESSES = get_context("forkserver")
"""Processes with preloaded modules that inherit no threads."""
PROCESSES.set_forkserver_preload(["vidstyle.cli.render", "vidstyle.pipeline.render"])


class Run:
    """A render in a separate process."""

    def __init__(self, source: Path, target: Path, *options: str) -> None:
        self._log = target.with_name(f"{target.name}.{time.monotonic_ns()}.txt")
        arguments = ["render", str(source), str(target), "--progress", "json", *options]
        self.process = PROCESSES.Process(target=_render, args=(arguments, self._log))
        self.process.start()

    @property
    def position_seconds(self) -> float:
        """Position in the film that the render has reached, in seconds."""
        return max((event.get("position", 0.0) for event in self._events()), default=0.0)

    @property
    def messages(self) -> list[str]:
        """Messages of the render."""
        return [event["text"] for event in self._events() if "text" in event]

    def _events(self) -> list[dict[str, Any]]:
        text = self._log.read_text(encoding="utf-8") if self._log.exists() else ""
        return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]

    def kill(self, position: float, delay: float) -> None:
        """Kill the render `delay` seconds after it has reached a position, in seconds of the film."""
        while self.process.is_alive() and self.position_seconds <= position:
            time.sleep(0.02)
        self.process.join(delay)
        self.process.kill()
        self.process.join()

    def end(self) -> int:
        """Wait for the end and return the exit code."""
        self.process.join()
        assert self.process.exitcode is not None
        return self.process.exitcode


def _render(arguments: list[str], messages: Path) -> None:
    os.dup2(os.open(messages, os.O_WRONLY | os.O_CREAT), 2)
    os._exit(cli.main(arguments))


def kill_renders(
    film: Path, folder: Path, arguments: argparse.Namespace, options: list[str], rng: random.Random
) -> int:
    """Kill renders, and continue the first of them; how many are not as they should be."""
    kinds = list(product(arguments.endings, arguments.styles))
    good = continued = kept = 0
    for number in range(arguments.times):
        ending, style = kinds[number % len(kinds)]
        is_resumed = number < arguments.resume
        target = folder / f"killed-{number}{ending}"
        settings = [*options, "--style", style, *(LOSSLESS if is_resumed else ())]
        run = Run(film, target, *settings)
        # Progress comes ten times a second.
        run.kill(rng.uniform(0, arguments.within), rng.uniform(0, 0.2))
        playable = playable_seconds(target)
        good += run.position_seconds - playable <= MAX_LOST_SECONDS
        print(
            f"{number} {ending} {style}: killed at {run.position_seconds:.2f} s of the film: "
            f"{playable:.2f} s play"
        )
        if is_resumed:
            whole = folder / f"whole-{style}{ending}"
            if not whole.exists():
                Run(film, whole, *settings).end()
            run = Run(film, target, *settings, "--resume")
            failure = (
                f"exit code {code}" if (code := run.end()) else find_difference(film, whole, target, run)
            )
            failure = failure or _find_leftovers(target)
            kept += any("frames are kept" in line and " 0 of" not in line for line in run.messages)
            continued += not failure
            print(
                f"  continued: {failure or 'as if it had never been killed'}; {' | '.join(run.messages)}",
                flush=True,
            )
        for path in folder.glob(f"{target.stem}*"):
            path.unlink()
    print(f"{good} of {arguments.times} miss at most {MAX_LOST_SECONDS:g} s")
    if arguments.resume:
        print(f"{continued} of {arguments.resume} continued as if never killed, {kept} of them amid the film")
    return arguments.times - good + arguments.resume - continued


def find_difference(film: Path, whole: Path, target: Path, run: Run) -> str:
    """Return how a resumed film is wrong, or ""."""
    border = next(
        (int(found[1]) for line in run.messages if (found := re.search(r"; (\d+) of \d+ frames", line))), 0
    )
    with open_reader(whole) as before, open_reader(target) as after:
        old, new = read_frames(before), read_frames(after)
        if [frame.time for frame in old] != [frame.time for frame in new]:
            return f"{len(new)} frames, not {len(old)}, or at other times"
        worst = [_max_luma_difference(one, other) for one, other in zip(old, new, strict=True)]
    with open_reader(film) as reader:
        detector = SceneCutDetector()
        cuts = [detector.is_cut(small_luma(frame.picture)) for frame in read_frames(reader)]
    cut = next((number for number in range(border, len(cuts)) if cuts[number]), len(cuts))
    if max(worst[:border], default=0) or max(worst[border:cut], default=0) > 1 or max(worst[cut:], default=0):
        return f"differs: {worst[:border]} {worst[border:cut]} {worst[cut:]}"
    return ""


def _max_luma_difference(one: Frame, other: Frame) -> int:
    """Return the maximum difference of luma in code values."""
    assert one.picture.luma is not None and other.picture.luma is not None
    return int(np.abs(one.picture.luma.astype(int) - other.picture.luma).max())


def playable_seconds(target: Path) -> float:
    """Return the playable length in seconds of the film that a render left, finished or not."""
    playable = [target, target.with_suffix(f".partial{target.suffix}")]
    film = next((path for path in playable if path.exists()), None)
    if film is None:
        return 0.0
    try:
        with open_reader(film) as reader:
            ends = [frame.time + (frame.duration or 0) * frame.time_base for frame in read_frames(reader)]
    except InputError:
        return 0.0
    return float(max(ends))


def read_frames(reader: Reader) -> list[Frame]:
    """Return all frames of a film."""
    return [item for item in reader if isinstance(item, Frame)]


def run_pairs(film: Path, folder: Path, pairs: int, rng: random.Random) -> int:
    """Let pairs of renders write the same file, and return the number of failures."""
    wrong, lasted = 0, 0.5
    for number in range(pairs):
        began = time.monotonic()
        target = folder / f"pair-{number}.mp4"
        overwrite = [rng.random() < 0.5 for _ in range(2)]
        runs = []
        for replaces, (size, count) in zip(overwrite, PAIR_FRAME_COUNTS.items(), strict=True):
            settings = ["--style", "plain", "--size", "{}x{}".format(*size), "--frames", str(count)]
            runs.append(Run(film, target, *settings, *["-y"] * replaces))
            time.sleep(rng.uniform(0, lasted / 2) if len(runs) == 1 else 0)
        codes = [run.end() for run in runs]
        lasted = (lasted + time.monotonic() - began) / 2
        failure = _find_pair_failure(target, runs, codes, overwrite)
        wrong += bool(failure)
        shown = [line for run in runs for line in run.messages if "frames in" not in line]
        print(f"{number} -y {overwrite}: exit codes {codes} {shown} {failure}", flush=True)
        for path in folder.glob(f"{target.stem}*"):
            path.unlink()
    if pairs:
        print(f"{pairs - wrong} of {pairs} pairs are right")
    return wrong


def _find_pair_failure(target: Path, runs: list[Run], codes: list[int], overwrite: list[bool]) -> str:
    if failure := _find_leftovers(target):
        return failure
    with open_reader(target) as reader:
        size, count = (reader.info.width, reader.info.height), len(read_frames(reader))
    if PAIR_FRAME_COUNTS.get(size) != count:
        return f"MIXED {size} {count}"
    owner = list(PAIR_FRAME_COUNTS).index(size)
    other = 1 - owner
    if codes[owner] != 0 or codes[other] == 0 and not overwrite[owner]:
        return "FALSE SUCCESS"
    named = f"is being written by process {runs[owner].process.pid}"
    reasons = named, "already exists", "appeared during the run"
    if codes[other] and not any(reason in line for line in runs[other].messages for reason in reasons):
        return "REFUSED WITHOUT A REASON"
    return ""


def _find_leftovers(target: Path) -> str:
    """Return the files that remain in addition to the target, or ""."""
    playable = [path.name for path in target.parent.glob(f"{target.stem}*") if path.suffix != ".txt"]
    return "" if playable == [target.name] else f"LEFT {playable}"


TEMPORARY_MARKS = ".partial", ".partial.2", ".vidstyle-0123456789abcdef", ".tmp", "~"
APPENDED_MARKS = (
    ".partial",
    ".partial.json",
    ".partial.jsonl",
    ".partial.vidstyle-0123456789abcdef.jsonl",
    ".lock",
    ".1",
)


def run_among_neighbors(film: Path, folder: Path, count: int, rng: random.Random) -> int:
    """Render among files of others, and return the number of runs that change one or end unexpectedly."""
    wrong = 0
    for number in range(count):
        place = folder / f"neighbors-{number}"
        place.mkdir()
        target = place / f"a{rng.choice(['.mp4', '.mov', '.mkv', '.avi', '.gif'])}"
        partial = f"a.partial{'.mkv' if target.suffix == '.gif' else target.suffix}"
        conflicting = {partial, f"{target.name}.partial.jsonl"}
        names = {f"a{mark}{ending}" for mark in TEMPORARY_MARKS for ending in (target.suffix, ".mkv")}
        names |= {f"{target.name}{mark}" for mark in APPENDED_MARKS} - conflicting
        names = names - conflicting | set(rng.sample(sorted(conflicting), rng.choice([0, 0, 1, 2])))
        for name in names:
            (place / name).write_bytes(film.read_bytes() if rng.random() < 0.5 else name.encode())
        failure, code = _find_changes(film, place, target, is_refused=bool(names & conflicting), rng=rng)
        wrong += bool(failure)
        print(f"{number} {target.name} {sorted(names & conflicting)}: exit code {code} {failure}", flush=True)
        shutil.rmtree(place)
    if count:
        print(f"{count - wrong} of {count} runs among files of others are right")
    return wrong


def _find_changes(
    film: Path, place: Path, target: Path, is_refused: bool, rng: random.Random
) -> tuple[str, int]:
    """Return how a run is wrong, or "", and its exit code; a third of the runs are killed and resumed."""
    source = rng.choice([film, *(path for path in place.iterdir() if path.stat().st_size > 1000)])
    options = ["--style", "plain", "--size", "320x180", *["-y"] * (rng.random() < 0.5)]
    before = {path.name: path.read_bytes() for path in place.iterdir()}
    is_resumable = target.suffix in (".mp4", ".mov", ".mkv")
    if is_resumable and rng.random() < 1 / 3:
        Run(source, target, *options).kill(0, rng.uniform(0, 0.5))
        options = [*options, "--resume"]
    code = Run(source, target, *options).end()
    after = {path.name: path.read_bytes() for path in place.iterdir() if path.suffix != ".txt"}
    made = after.pop(target.name, None)
    if after != before:
        return (
            f"CHANGED {[name for name in {**before, **after} if before.get(name) != after.get(name)]}",
            code,
        )
    return (
        "" if (code, made is None) == ((2, True) if is_refused else (0, False)) else "NOT AS EXPECTED"
    ), code


if __name__ == "__main__":
    main()
