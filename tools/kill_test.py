"""Kills renders at random times, continues them, and lets two at a time write one file.

    python tools/kill_test.py --times 100 --endings .mp4 .mkv .mov --styles plain ink comic --resume 20

A killed render may miss the last 2 seconds of the film that it had reached, no more. One that is
continued has the frame times of a render that was never killed, the same pictures from the first cut
after the border on, and pictures within one code before.

    python tools/kill_test.py --times 0 --pairs 200

Of two renders onto one file, begun at random times and with or without -y, one at least succeeds; a
success is that of the film that is there, and nothing else is left.

    python tools/kill_test.py --times 0 --neighbors 100

Renders, a third of them killed and continued, in a folder whose other files have the names that the
program uses or has used for temporary files. None of these changes; what is in the way is refused.
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

MAY_MISS_SECONDS = 2.0
LOSSLESS = ("--codec", "libx264", "--crf", "0")
PAIR = {(96, 54): 20, (80, 46): 26}
"""The size of each render's pictures, and how many there are: so it shows whose the file is."""


def main() -> None:
    """Kill, continue and pair renders; fail if a film is not what it should be."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--resume", type=int, default=0, help="how many of the killed renders to continue")
    parser.add_argument("--pairs", type=int, default=0, help="how many pairs of renders onto one file")
    parser.add_argument("--neighbors", type=int, default=0, help="how many renders among files of others")
    parser.add_argument("--repeats", type=int, default=6, help="length of the film, in fours of seconds")
    parser.add_argument("--film", type=Path, help="film to render, instead of one that is made")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--within", type=float, default=20.0, help="kill within so many seconds of the film")
    parser.add_argument("--endings", nargs="+", default=[".mp4"])
    parser.add_argument("--styles", nargs="+", default=["plain"])
    parser.add_argument("--options", default="--size 1280x720", help="for vidstyle render")
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        film = arguments.film or folder / "film.mp4"
        if not arguments.film:
            make_film(film, repeats=arguments.repeats)
        options = shlex.split(arguments.options)
        bad = killed(film, folder, arguments, options, chance) + paired(film, folder, arguments.pairs, chance)
        bad += among_neighbors(film, folder, arguments.neighbors, chance)
    sys.exit(bad > 0)


PROCESSES = get_context("forkserver")
"""Processes that need not load anything, and inherit no threads."""
PROCESSES.set_forkserver_preload(["vidstyle.cli.render", "vidstyle.pipeline.render"])


class Run:
    """A render in a process of its own."""

    def __init__(self, source: Path, target: Path, *options: str) -> None:
        self._said = target.with_name(f"{target.name}.{time.monotonic_ns()}.txt")
        arguments = ["render", str(source), str(target), "--progress", "json", *options]
        self.process = PROCESSES.Process(target=_render, args=(arguments, self._said))
        self.process.start()

    @property
    def reached(self) -> float:
        """How far it has come, in seconds of the film."""
        return max((event.get("position", 0.0) for event in self._events()), default=0.0)

    @property
    def said(self) -> list[str]:
        """Its messages."""
        return [event["text"] for event in self._events() if "text" in event]

    def _events(self) -> list[dict[str, Any]]:
        text = self._said.read_text(encoding="utf-8") if self._said.exists() else ""
        return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]

    def kill(self, position: float, delay: float) -> None:
        """Kill it so many seconds after it has reached a position in the film, if it still runs."""
        while self.process.is_alive() and self.reached <= position:
            time.sleep(0.02)
        self.process.join(delay)
        self.process.kill()
        self.process.join()

    def end(self) -> int:
        """Wait for its end; the exit code."""
        self.process.join()
        assert self.process.exitcode is not None
        return self.process.exitcode


def _render(arguments: list[str], said: Path) -> None:
    os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT), 2)
    os._exit(cli.main(arguments))


def killed(
    film: Path, folder: Path, arguments: argparse.Namespace, options: list[str], chance: random.Random
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
        run.kill(chance.uniform(0, arguments.within), chance.uniform(0, 0.2))
        left = seconds_left(target)
        good += run.reached - left <= MAY_MISS_SECONDS
        print(f"{number} {ending} {style}: killed at {run.reached:.2f} s of the film: {left:.2f} s play")
        if is_resumed:
            whole = folder / f"whole-{style}{ending}"
            if not whole.exists():
                Run(film, whole, *settings).end()
            run = Run(film, target, *settings, "--resume")
            failure = f"exit code {code}" if (code := run.end()) else difference(film, whole, target, run)
            failure = failure or _surplus(target)
            kept += any("frames are kept" in line and " 0 of" not in line for line in run.said)
            continued += not failure
            print(
                f"  continued: {failure or 'as if it had never been killed'}; {' | '.join(run.said)}",
                flush=True,
            )
        for path in folder.glob(f"{target.stem}*"):
            path.unlink()
    print(f"{good} of {arguments.times} miss at most {MAY_MISS_SECONDS:g} s")
    if arguments.resume:
        print(f"{continued} of {arguments.resume} continued as if never killed, {kept} of them amid the film")
    return arguments.times - good + arguments.resume - continued


def difference(film: Path, whole: Path, target: Path, run: Run) -> str:
    """What is wrong with a film that was continued, or ""."""
    border = next(
        (int(found[1]) for line in run.said if (found := re.search(r"; (\d+) of \d+ frames", line))), 0
    )
    with open_reader(whole) as before, open_reader(target) as after:
        old, new = frames(before), frames(after)
        if [frame.time for frame in old] != [frame.time for frame in new]:
            return f"{len(new)} frames, not {len(old)}, or at other times"
        worst = [_distance(one, other) for one, other in zip(old, new, strict=True)]
    with open_reader(film) as reader:
        detector = SceneCutDetector()
        cuts = [detector.is_cut(small_luma(frame.picture)) for frame in frames(reader)]
    cut = next((number for number in range(border, len(cuts)) if cuts[number]), len(cuts))
    if max(worst[:border], default=0) or max(worst[border:cut], default=0) > 1 or max(worst[cut:], default=0):
        return f"differs: {worst[:border]} {worst[border:cut]} {worst[cut:]}"
    return ""


def _distance(one: Frame, other: Frame) -> int:
    """The greatest difference of luma, in codes."""
    assert one.picture.luma is not None and other.picture.luma is not None
    return int(np.abs(one.picture.luma.astype(int) - other.picture.luma).max())


def seconds_left(target: Path) -> float:
    """How long the film plays that the render has left, finished or not."""
    left = [target, target.with_suffix(f".partial{target.suffix}")]
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


def paired(film: Path, folder: Path, pairs: int, chance: random.Random) -> int:
    """Let pairs of renders write one file; how many go wrong."""
    wrong, lasted = 0, 0.5
    for number in range(pairs):
        began = time.monotonic()
        target = folder / f"pair-{number}.mp4"
        overwrite = [chance.random() < 0.5 for _ in range(2)]
        runs = []
        for replaces, (size, count) in zip(overwrite, PAIR.items(), strict=True):
            settings = ["--style", "plain", "--size", "{}x{}".format(*size), "--frames", str(count)]
            runs.append(Run(film, target, *settings, *["-y"] * replaces))
            time.sleep(chance.uniform(0, lasted / 2) if len(runs) == 1 else 0)
        codes = [run.end() for run in runs]
        lasted = (lasted + time.monotonic() - began) / 2
        failure = _pair_failure(target, runs, codes, overwrite)
        wrong += bool(failure)
        told = [line for run in runs for line in run.said if "frames in" not in line]
        print(f"{number} -y {overwrite}: exit codes {codes} {told} {failure}", flush=True)
        for path in folder.glob(f"{target.stem}*"):
            path.unlink()
    if pairs:
        print(f"{pairs - wrong} of {pairs} pairs are right")
    return wrong


def _pair_failure(target: Path, runs: list[Run], codes: list[int], overwrite: list[bool]) -> str:
    if failure := _surplus(target):
        return failure
    with open_reader(target) as reader:
        size, count = (reader.info.width, reader.info.height), len(frames(reader))
    if PAIR.get(size) != count:
        return f"MIXED {size} {count}"
    owner = list(PAIR).index(size)
    other = 1 - owner
    if codes[owner] != 0 or codes[other] == 0 and not overwrite[owner]:
        return "FALSE SUCCESS"
    named = f"is being written by process {runs[owner].process.pid}"
    reasons = named, "already exists", "appeared during the run"
    if codes[other] and not any(reason in line for line in runs[other].said for reason in reasons):
        return "REFUSED WITHOUT A REASON"
    return ""


def _surplus(target: Path) -> str:
    """What is left besides the target, or ""."""
    left = [path.name for path in target.parent.glob(f"{target.stem}*") if path.suffix != ".txt"]
    return "" if left == [target.name] else f"LEFT {left}"


MARKS = ".partial", ".partial.2", ".vidstyle-0123456789abcdef", ".tmp", "~"
APPENDED = (
    ".partial",
    ".partial.json",
    ".partial.jsonl",
    ".partial.vidstyle-0123456789abcdef.jsonl",
    ".lock",
    ".1",
)


def among_neighbors(film: Path, folder: Path, count: int, chance: random.Random) -> int:
    """Render among files of others; how many runs change one of them, or end otherwise than they should."""
    wrong = 0
    for number in range(count):
        place = folder / f"neighbors-{number}"
        place.mkdir()
        target = place / f"a{chance.choice(['.mp4', '.mov', '.mkv', '.avi', '.gif'])}"
        partial = f"a.partial{'.mkv' if target.suffix == '.gif' else target.suffix}"
        in_the_way = {partial, f"{target.name}.partial.jsonl"}
        names = {f"a{mark}{ending}" for mark in MARKS for ending in (target.suffix, ".mkv")}
        names |= {f"{target.name}{mark}" for mark in APPENDED} - in_the_way
        names = names - in_the_way | set(chance.sample(sorted(in_the_way), chance.choice([0, 0, 1, 2])))
        for name in names:
            (place / name).write_bytes(film.read_bytes() if chance.random() < 0.5 else name.encode())
        failure, code = _changes(film, place, target, is_refused=bool(names & in_the_way), chance=chance)
        wrong += bool(failure)
        print(f"{number} {target.name} {sorted(names & in_the_way)}: exit code {code} {failure}", flush=True)
        shutil.rmtree(place)
    if count:
        print(f"{count - wrong} of {count} runs among files of others are right")
    return wrong


def _changes(
    film: Path, place: Path, target: Path, is_refused: bool, chance: random.Random
) -> tuple[str, int]:
    """What a run, killed and continued in a third of the cases, has done wrong, and its exit code."""
    source = chance.choice([film, *(path for path in place.iterdir() if path.stat().st_size > 1000)])
    options = ["--style", "plain", "--size", "320x180", *["-y"] * (chance.random() < 0.5)]
    before = {path.name: path.read_bytes() for path in place.iterdir()}
    is_resumable = target.suffix in (".mp4", ".mov", ".mkv")
    if is_resumable and chance.random() < 1 / 3:
        Run(source, target, *options).kill(0, chance.uniform(0, 0.5))
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
