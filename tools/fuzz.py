"""Gives damaged files to the program: `python tools/fuzz.py --seconds 60 --seed 1 --kind film`.

Films, pictures, style files, banks and subtitle files of tests/support/mutations.py go through the Python API
in worker processes. A crash, a hang, an exception that is no `VidstyleError` and memory above the limit are
finds: each becomes a file in tests/fixtures/found, all of which tests/faults/test_found.py tries. A case
depends on the seed, its kind and its number alone, so that a seed reproduces a find.
"""

from __future__ import annotations

import argparse
import itertools
import logging
import math
import multiprocessing
import os
import resource
import shutil
import sys
import tempfile
import threading
import time
import traceback
import zlib
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from contextlib import closing
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
from PIL import Image

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tests" / "support")]

from media import moving_frames  # noqa: E402
from mutations import SIZE, mutated, whole_files  # noqa: E402

from vidstyle.comic.make import ComicOptions, make_comic  # noqa: E402
from vidstyle.errors import VidstyleError  # noqa: E402
from vidstyle.pipeline.render import render  # noqa: E402
from vidstyle.renderer import Renderer, stylize  # noqa: E402
from vidstyle.style import load_style, save_style, style_names  # noqa: E402

FOUND = ROOT / "tests" / "fixtures" / "found"
SECONDS = 20.0
"""Of a processor: a case that takes longer is taken to hang."""
MAX_MEMORY = 2**30
"""Bytes of RAM that a case may take on top of what its worker had before."""
MAX_ADDRESSES = 2**33
"""Bytes of addresses that it may take, so that a find does not take down the machine."""
TARGETS = ("out_%05d.png", "out.mkv", "out.mp4", "out.avi", "out.mov", "out.ts")
"""What films and pictures become: sound and subtitles are copied, encoded anew or left out."""


def attempt(path: Path, folder: Path) -> None:
    """Use a file as its ending says, writing into a folder that holds nothing else.

    Raises:
        VidstyleError: the file cannot be used.
    """
    tried, choice = ATTEMPTS.get(path.suffix, _try_media), zlib.crc32(path.read_bytes())
    tried(path, folder, choice)


def _try_media(path: Path, folder: Path, choice: int) -> None:
    """A film or picture in one of the styles; of some films, a comic."""
    target = TARGETS[(choice >> 8) % len(TARGETS)]
    render(path, folder / target, _style_for(choice))
    if choice % 8 == 0:
        make_comic(path, folder / "page.png", ComicOptions(size="320x240"))


def _try_array(path: Path, folder: Path, choice: int) -> None:
    stylize(np.load(path), _style_for(choice))


def _style_for(choice: int) -> str:
    names = style_names()
    return names[choice % len(names)]


def _try_style(path: Path, folder: Path, choice: int) -> None:
    """Three frames in the style and in its variants; saved and read again."""
    style = load_style(path)
    save_style(style, shutil.copy(path, folder / "copy.toml"))
    load_style(folder / "copy.toml")
    for name in ("", *(f":{variant}" for variant in style.variants)):
        with Renderer(load_style(f"{path}{name}"), device="cpu") as renderer:
            for picture in moving_frames(3, SIZE):
                renderer(picture)


def _try_bank(path: Path, folder: Path, choice: int) -> None:
    """The bank in a style beside it."""
    style = folder / "style.toml"
    step = f'block = "learned"\nbank = "bank.npz"\npasses = {choice % 8 + 1}'
    style.write_text(f"format = 1\n[[base]]\n{step}\n[[background]]\nblock = 'posterize'\n")
    shutil.copy(path, folder / "bank.npz")
    _try_style(style, folder, choice)


def _try_subtitles(path: Path, folder: Path, choice: int) -> None:
    """A comic of three pictures with the subtitles."""
    (pictures := folder / "pictures").mkdir()
    for number, picture in enumerate(moving_frames(3, (160, 120))):
        Image.fromarray(picture).save(pictures / f"{number}.png")
    options = ComicOptions(size="480x360", subtitles=str(path))
    make_comic(pictures, folder / "page.png", options)


ATTEMPTS = {".npy": _try_array, ".toml": _try_style, ".npz": _try_bank} | dict.fromkeys(
    (".srt", ".vtt", ".ass"), _try_subtitles
)
"""What is done with a file, by its ending; with any other, `_try_media`."""
KINDS = ("film", "picture", "style", "bank", "subtitle")


class Case(NamedTuple):
    """What a file is made from."""

    kind: str
    seed: int
    number: int


class Worker:
    """A process that tries one file after another; a new one is started where one ends it or hangs."""

    def __init__(self, whole: dict[str, list[Path]], trial: Callable[[Path, Path], None] = attempt) -> None:
        self._arguments = whole, trial
        self._process: BaseProcess | None = None

    def outcome(self, case: Case, seconds: float = SECONDS) -> str:
        """Whether the file was used or refused, or what was found."""
        if self._process is None:
            self._start()
        self._pipe.send(case)
        try:
            found = self._pipe.recv() if self._answers(seconds) else "hang"
        except EOFError:
            found = "crash"
        if found not in ("used", "refused"):
            self.close()
        return found

    def _answers(self, seconds: float) -> bool:
        """Whether it answers within so many seconds of a processor, or ten times as many of the clock."""
        process, end = psutil.Process(self._process.pid), time.monotonic() + 10 * seconds
        limit = seconds + sum(process.cpu_times()[:2])
        while time.monotonic() < end and sum(process.cpu_times()[:2]) < limit:
            if self._pipe.poll(0.5):
                return True
        return False

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, far = context.Pipe()
        self._process = context.Process(target=work, args=(far, *self._arguments), daemon=True)
        self._process.start()
        far.close()
        self._pipe.recv()


def work(pipe: Connection, whole: dict[str, list[Path]], trial: Callable[[Path, Path], None]) -> None:
    """Answer each case from the pipe by its outcome."""
    os.nice(10)
    logging.getLogger("vidstyle").setLevel(logging.CRITICAL)
    resource.setrlimit(resource.RLIMIT_AS, (MAX_ADDRESSES, MAX_ADDRESSES))
    pipe.send("ready")
    while True:
        kind, seed, number = pipe.recv()
        suffix, content = mutated(kind, seed, number, whole)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"case{suffix}")
            path.write_bytes(content)
            Path(folder, "out").mkdir()
            pipe.send(_outcome(trial, path, Path(folder, "out")))


def _outcome(trial: Callable[[Path, Path], None], path: Path, folder: Path) -> str:
    Path("/proc/self/clear_refs").write_text("5")  # the highest memory is counted anew
    before = _memory("VmRSS")
    try:
        trial(path, folder)
        found = "used"
    except VidstyleError:
        found = "refused"
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        found = f"{type(error).__name__} in {Path(place.filename).name}:{place.lineno}"
    more = _memory("VmHWM") - before
    return f"memory: {more >> 20} MiB" if more > MAX_MEMORY else found


def _memory(field: str) -> int:
    """Of this process, in bytes."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith(field))


def main() -> None:
    """Try cases until the time or their count is up; fail if anything was found."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, help="default: 60, or as long as --count takes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=KINDS, action="append", help="may be repeated; default: all")
    parser.add_argument("--count", type=int, help="how many cases of each kind")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--found", type=Path, default=FOUND, help="folder for the finds")
    chosen = parser.parse_args()
    count = math.inf if chosen.count is None else chosen.count
    end = time.monotonic() + (chosen.seconds or (60 if chosen.count is None else math.inf))
    numbers = itertools.takewhile(
        lambda number: number < chosen.first + count and time.monotonic() < end, itertools.count(chosen.first)
    )
    kinds = chosen.kind or KINDS
    cases = (Case(kind, chosen.seed, number) for number in numbers for kind in kinds)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TMPDIR"] = folder  # so that nothing is left of workers that crash
        whole = whole_files(Path(folder), kinds)
        counts = try_all(cases, whole, chosen.found, chosen.workers)
    for kind, outcomes in counts.items():
        said = ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
        print(f"{kind}: {outcomes.total()} cases of seed {chosen.seed}: {said}")
    sys.exit(any(outcomes.keys() - {"used", "refused"} for outcomes in counts.values()))


def try_all(
    cases: Iterator[Case], whole: dict[str, list[Path]], found: Path, workers: int
) -> dict[str, Counter[str]]:
    """Try the cases in several workers and keep each find; how often each outcome was, by kind."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    lock = threading.Lock()

    def take_turns() -> None:
        with closing(Worker(whole)) as worker:
            while True:
                with lock:
                    case = next(cases, None)
                if case is None:
                    return
                outcome = worker.outcome(case)
                with lock:
                    counts[case.kind][outcome.partition(":")[0]] += 1
                if outcome not in ("used", "refused"):
                    keep(case, outcome, whole, found)

    threads = [threading.Thread(target=take_turns) for _ in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return counts


def keep(case: Case, outcome: str, whole: dict[str, list[Path]], found: Path) -> None:
    """Write what was found as a file."""
    suffix, content = mutated(*case, whole)
    path = found / f"{case.kind}-{case.seed}-{case.number}{suffix}"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    print(f"{path.name}: {outcome}", flush=True)


if __name__ == "__main__":
    main()
